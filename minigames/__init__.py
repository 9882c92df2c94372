"""The minigames: Scenic programs as data. Importing this registers them with Gymnasium.

    import gymnasium, minigames
    env = gymnasium.make("regista/1v1Free-v0")                        # one match
    envs = gymnasium.make_vec("regista/1v1Free-v0", num_envs=256)     # a native batch, a new level every episode

    env = minigames.parallel_env("3v2FourBehaviors", control="all")   # a match by agents, as PettingZoo has it

A test scene is an environment, too: `regista/1v1Free_hard-v0`. Read next: `suites`.
"""

from typing import Any

import gymnasium

from regista.minigames.suites import ACADEMY, BENCHMARK, MINIGAMES, NAMED, Minigame

__all__ = ["ACADEMY", "BENCHMARK", "MINIGAMES", "Minigame", "parallel_env"]

for _game in NAMED.values():
    gymnasium.register(
        f"regista/{_game.name.replace('/', '_')}-v0",
        entry_point="regista.envs.football.gym_env:FootballEnv",
        vector_entry_point="regista.envs.football.vector_env:make_vec",
        kwargs={"program": str(_game.program), "control": _game.control},
    )


def parallel_env(minigame: str, **settings: Any) -> Any:
    """Make a minigame into a PettingZoo `ParallelEnv`; `settings` are those of `FootballParallelEnv`.

    Agents move whom a team moves in the minigame, or all, unless `control` and `right_control` say otherwise. Raises
    ValueError for an unknown name or a control mode that does not fit, ImportError without PettingZoo.
    """
    if minigame not in NAMED:
        raise ValueError(f"unknown minigame {minigame!r}; known are {', '.join(NAMED)}")
    try:
        from regista.envs.football.parallel_env import FootballParallelEnv
    except ImportError as error:
        raise ImportError("a parallel_env needs PettingZoo: pip install 'regista[pettingzoo]'") from error
    game = NAMED[minigame]
    control = game.team_control[0] if game.team_control else "all"
    return FootballParallelEnv(str(game.program), **{"control": control, **settings})
