"""Minigames and mazes as environments of Gymnasium (ids registered on import) and PettingZoo (`parallel_env`).

Ids of minigames end in the version of the simulator. For an older version, Gymnasium reports that it is deprecated and
names the current id. Read next: `suites`, the games that are registered; `envs.maze.gym_env`, mazes.
"""

from typing import Any

import gymnasium

from regista.envs.football.version import SIMULATOR_VERSION
from regista.minigames.suites import NAMED

for _game in NAMED.values():
    gymnasium.register(
        f"regista/{_game.name.replace('/', '_')}-v{SIMULATOR_VERSION}",
        entry_point="regista.envs.football.gym_env:FootballEnv",
        vector_entry_point="regista.envs.football.vector_env:make_vec",
        kwargs={"program": str(_game.program), "control": _game.control},
    )

gymnasium.register(
    "regista/Maze-v0",
    entry_point="regista.envs.maze.gym_env:MazeEnv",
    vector_entry_point="regista.envs.maze.gym_env:make_vec",
)


def parallel_env(minigame: str, **settings: Any) -> Any:
    """Return a minigame as a PettingZoo `ParallelEnv`; `settings` are the arguments of `FootballParallelEnv`.

    By default agents move the players of the minigame's team mode, or all players; `control` and `right_control`
    override it. Raises ValueError for an unknown name or a control mode that does not fit, ImportError without
    PettingZoo.
    """
    if minigame not in NAMED:
        raise ValueError(f"unknown minigame {minigame!r}; known are {', '.join(NAMED)}")
    try:
        from regista.envs.football.parallel_env import FootballParallelEnv
    except ImportError as error:
        raise ImportError("parallel_env requires PettingZoo: pip install 'regista[pettingzoo]'") from error
    game = NAMED[minigame]
    control = game.team_control[0] if game.team_control else "all"
    return FootballParallelEnv(str(game.program), **{"control": control, **settings})
