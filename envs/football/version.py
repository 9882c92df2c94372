"""The version of the simulator. Equal numbers mean equal play: results of one version can be compared.

Raise the number when a program, with the same seeds and actions, is played, observed or rewarded otherwise than before.
`tests/envs/test_simulator_version.py` fails until then. Refactoring and speed work leave the number as it is. No kernel
imports this file, so that another number compiles nothing anew.

What raising it costs: Gymnasium ids end in the new number, and the old ones stop working. Runs, demonstrations and
records of the old version cannot be resumed, cloned or replayed. Published tables must be measured again, whole. Old
policies can still be evaluated, with a warning.

What plays on Google Research Football (`engine = "grf"`) is not of this simulator and carries no number.
"""

from __future__ import annotations

SIMULATOR_VERSION = 1
UNNUMBERED = 0  # of what was played before the simulator had a version, and so carries no number


def simulator_name(version: int) -> str:
    """Return what a version is called in a sentence."""
    return f"simulator version {version}" if version else "an unnumbered simulator, from before version 1"


def version_on(engine: str) -> int | None:
    """Return the version of what plays where `FootballConfig.engine` is this; None for the real engine."""
    return SIMULATOR_VERSION if engine == "regista" else None
