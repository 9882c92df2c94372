"""The minigames: Scenic programs as data. Importing this package registers them with Gymnasium.

    import gymnasium
    from regista import minigames

    env = gymnasium.make("regista/1v1Free-v1")                        # one match
    envs = gymnasium.make_vec("regista/1v1Free-v1", num_envs=256)     # a native batch, a new level every episode

    env = minigames.parallel_env("3v2FourBehaviors", control="all")   # a PettingZoo environment

Test scenes are environments, too: `regista/1v1Free_hard-v1`. `regista/minigames` is a link to this folder.
Read next: `suites`.
"""

from regista.minigames.environments import parallel_env
from regista.minigames.suites import ACADEMY, BENCHMARK, MINIGAMES, Minigame

__all__ = ["ACADEMY", "BENCHMARK", "MINIGAMES", "Minigame", "parallel_env"]

if __name__ == "minigames":  # the root of a checkout is on `sys.path`
    from regista.bare_names import lead_inside

    lead_inside(__name__)
