"""The original Scenic 3: programs loaded by its interpreter, run in one of its simulators, as a UPOMDP.

    from regista.envs.scenic3 import Role, ScenicProgram, ScenicUPOMDP

    upomdp = ScenicUPOMDP(ScenicProgram("overtake.scenic", mode_2d=True), Driver(), num_envs=4)

A program's random values become θ: see `program`. A task also needs a `Role`: observations, actions and rewards of the
agent. Install it with `pip install 'regista[scenic3]'`.
Read next: `columns`, random values; `program`, scenes; `episode`, a simulation driven step by step; `vector_env`.
"""

try:
    import greenlet  # noqa: F401
    import scenic  # noqa: F401
except ImportError as error:
    raise ImportError(
        f"programs of the original Scenic need scenic and greenlet: pip install 'regista[scenic3]' ({error})"
    ) from error

from regista.envs.scenic3.episode import Episode, Role
from regista.envs.scenic3.program import ScenicProgram
from regista.envs.scenic3.vector_env import ScenicUPOMDP

__all__ = ["Episode", "Role", "ScenicProgram", "ScenicUPOMDP"]
