"""Short ways to load a program and look at one scene."""

import numpy as np

from scenic_lite import Program, Scenes, load

BARE = "class Thing:\n    requireVisible: False\n    allowCollisions: True\n"


def one_scene(text: str, dialect: int = 2, theta: float = 0.0) -> Scenes:
    """The scene at the middle of θ (or at `theta` in every column); `Thing` is an object without any rule."""
    program = things(text, dialect)
    return program.instantiate(np.full((1, program.dim), theta))


def things(text: str, dialect: int = 2) -> Program:
    """A program about Things; unless it says otherwise its ego stands at (1, 2) and looks along -x."""
    start = "" if "ego =" in text else "ego = new Thing at 1 @ 2, facing 90 deg\n"
    return load(BARE + start + text, dialect=dialect)


def param(text: str, dialect: int = 2, theta: float = 0.0):
    """The value of an expression, as parameter of a program."""
    scenes = one_scene(f"param value = {text}", dialect, theta)
    return scenes.params["value"]
