"""Player-steps: matches from strange places, of which every step is watched, and the minigames' programs.

Read next: `tests.envs.torture` and `tests.envs.program_play`.
"""

from __future__ import annotations

from tests.envs import program_play
from tests.envs.torture import torture

STEPS = 2_500  # of each of a round's matches


def attack(count: int, seed: int) -> dict[str, int]:
    """Play so many matches and a batch of one program; return the player-steps. Raises AssertionError for any harm."""
    return {"sane": torture(count, STEPS, seed) + program_play.play(seed)}
