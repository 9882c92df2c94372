"""Scenic 3 itself: a program that the original interpreter loads, on a simulator of its own, as a UPOMDP.

    from regista.envs.scenic3 import Role, ScenicProgram, ScenicUPOMDP

    upomdp = ScenicUPOMDP(ScenicProgram("overtake.scenic", mode_2d=True), Driver(), num_envs=4)

What a program leaves to chance becomes θ: `program`. What it leaves open is a `Role`: what the agent sees, may do and
is paid for. It needs `pip install 'regista[scenic3]'`.
Read next: `columns`, what is random; `program`, scenes; `episode`, a simulation turned inside out; `vector_env`.
"""

try:
    import greenlet  # noqa: F401
    import scenic  # noqa: F401
except ImportError as error:
    raise ImportError(
        f"programs for Scenic itself need it and greenlet: pip install 'regista[scenic3]' ({error})"
    ) from error

from regista.envs.scenic3.episode import Episode, Role
from regista.envs.scenic3.program import ScenicProgram
from regista.envs.scenic3.vector_env import ScenicUPOMDP

__all__ = ["Episode", "Role", "ScenicProgram", "ScenicUPOMDP"]
