"""Engines for the tests of `regista.envs.grf`: a stand-in that is always there, and the real one where it is installed.

Read next: `fake_gfootball`.
"""

import json
import sys
from pathlib import Path

import pytest

from regista.envs.grf.workers import GrfError, grf_python

HERE = Path(__file__).parent
SCENE = {
    "settings": {"game_duration": 400, "deterministic": False},
    "ball": [0.62, 0.0],
    "left": [[-1.0, 0.0, 0, False, True], [0.6, 0.0, 5, False, True]],
    "right": [[-1.0, 0.0, 0, False, True]],
    "agents": [1, 0],
}


def fake_python(folder: Path, **plan: object) -> Path:
    """Write a Python whose gfootball is the stand-in, which misbehaves as planned."""
    script = folder / "python"
    words = f"FAKE_GRF='{json.dumps(plan)}' exec {sys.executable} {HERE / 'fake_gfootball.py'} \"$@\""
    script.write_text(f"#!/bin/sh\n{words}\n")
    script.chmod(0o755)
    return script


def real_python() -> str:
    """Return the Python that has the real engine; skip the test where there is none."""
    try:
        return str(grf_python())
    except GrfError as error:
        pytest.skip(str(error))
