"""The minigames: Scenic programs as data. Importing this registers them with Gymnasium.

    import gymnasium, minigames
    env = gymnasium.make("regista/1v1Free-v0")                        # one match
    envs = gymnasium.make_vec("regista/1v1Free-v0", num_envs=256)     # a native batch, a new level every episode

A test scene is an environment, too: `regista/1v1Free_hard-v0`. Read next: `suites`.
"""

import gymnasium

from minigames.suites import ACADEMY, BENCHMARK, MINIGAMES, NAMED, Minigame

__all__ = ["ACADEMY", "BENCHMARK", "MINIGAMES", "Minigame"]

for _game in NAMED.values():
    gymnasium.register(
        f"regista/{_game.name.replace('/', '_')}-v0",
        entry_point="envs.football.gym_env:FootballEnv",
        vector_entry_point="envs.football.vector_env:make_vec",
        kwargs={"program": str(_game.program), "control": _game.control},
    )
