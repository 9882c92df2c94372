"""Player-steps: matches from unusual states with every step checked, and the minigames' programs.

Read next: `tests.envs.torture` and `tests.envs.program_play`.
"""

from __future__ import annotations

from tests.envs import program_play
from tests.envs.torture import torture

STEPS = 2_500  # of each match of a round


def attack(count: int, seed: int) -> dict[str, int]:
    """Play `count` matches and a batch of one program; return the player-steps. Raises AssertionError for any harm."""
    return {"sane": torture(count, STEPS, seed) + program_play.play(seed)}
