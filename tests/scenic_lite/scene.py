"""Short ways to load a program and look at one scene."""

import numpy as np

from scenic_lite import Program, Scenes, load

BARE = "class Thing:\n    requireVisible: False\n    allowCollisions: True\n"


def one_scene(text: str, dialect: int = 2, theta: float = 0.0) -> Scenes:
    """Return the scene at the middle of θ (or at `theta` in every column); `Thing` is an object without any rule."""
    program = things(text, dialect)
    return program.instantiate(np.full((1, program.dim), theta))


def things(text: str, dialect: int = 2) -> Program:
    """Return a program about Things; unless it says otherwise its ego stands at (1, 2) and looks along -x."""
    start = "" if "ego =" in text else "ego = new Thing at 1 @ 2, facing 90 deg\n"
    return load(BARE + start + text, dialect=dialect)


def param(text: str, dialect: int = 2, theta: float = 0.0):
    """Return the value of an expression, as parameter of a program."""
    scenes = one_scene(f"param value = {text}", dialect, theta)
    return scenes.params["value"]


def described(scenes: Scenes) -> dict:
    """Describe scenes as a person would for `Program.theta`: places, and all numbers and texts that vary."""
    description = {name: value for name, value in map(asked, scenes.params.items()) if value is not None}
    for i in range(scenes.positions.shape[1]):
        values = ((name, column[i]) for name, column in scenes.properties.items())
        held = {name: value for name, value in map(asked, values) if value is not None}
        description[i] = held | {"position": scenes.positions[:, i], "heading": scenes.headings[:, i]}
    return description


def asked(pair: tuple) -> tuple:
    """Return a value of scenes with its name, None for what is the same in all or is no number, text or place."""
    name, value = pair
    if not isinstance(value, np.ndarray):
        return name, None
    if value.dtype.kind == "O":
        return name, value if all(isinstance(each, str) for each in value) else None
    return name, value
