"""The version of the simulator. Results of the same version are comparable: its matches play identically.

Raise the number when play, observations or rewards of a program change for the same seeds and actions.
`tests/envs/test_simulator_version.py` fails until then. Refactoring and speed work leave the number unchanged. No
kernel imports this file, so a new number does not recompile any.

Costs of a new version: Gymnasium ids end in the new number, and the old ids stop working. Runs, demonstrations and
records of the old version cannot be resumed, cloned or replayed. All published tables must be measured again. Old
policies can still be evaluated, with a warning.

Matches of Google Research Football (`engine = "grf"`) carry no number.
"""

from __future__ import annotations

SIMULATOR_VERSION = 1
UNNUMBERED = 0  # of files from a simulator without a version number


def simulator_name(version: int) -> str:
    """Return the name of a version, for use in a sentence."""
    return f"simulator version {version}" if version else "an unnumbered simulator, from before version 1"


def version_on(engine: str) -> int | None:
    """Return the simulator version for `FootballConfig.engine`; None for GRF."""
    return SIMULATOR_VERSION if engine == "regista" else None
