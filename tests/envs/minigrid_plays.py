"""Recorded episodes of minigrid 3.2.0, so that tests compare with it where the package is not installed.

`minigrid_maze` records them.
"""

from pathlib import Path

import numpy as np

from regista.envs.maze.config import MazeConfig
from regista.envs.maze.env import Mazes

RECORDED = {  # name: settings, mazes, steps
    "25 walls": (MazeConfig(max_steps=70), 12, 80),
    "60 walls, hide": (MazeConfig(num_walls=60, random_count=True, see_through=False, max_steps=70), 24, 80),
    "5 x 5, hide": (MazeConfig(side=5, num_walls=6, max_steps=20, see_through=False), 60, 80),
}


def vectors_of(images: np.ndarray, directions: np.ndarray, config: MazeConfig) -> np.ndarray:
    """Return the features `[N, F]` of MiniGrid's images `[N, 5, 5, 3]` and directions `[N]`."""
    things = images[..., 0].reshape(len(images), -1)
    planes = [things == 2, things == 8] + ([] if config.see_through else [things > 0])
    return np.concatenate([*planes, np.eye(4)[directions]], 1).astype(np.float32)


def compare_with_recorded(name: str) -> dict[str, int]:
    """Play the mazes and actions of a recording; raise AssertionError at a difference, return what was compared."""
    config, num_mazes, _ = RECORDED[name]
    with np.load(Path(__file__).with_name("minigrid_plays.npz")) as file:
        kept = {key.removeprefix(f"{name} "): file[key] for key in file.files if key.startswith(f"{name} ")}
    ours = Mazes(num_mazes, config)
    ours.reset(options={"theta": kept["theta"]})
    for step, actions in enumerate(kept["actions"]):
        vectors, *others, _ = ours.advance(actions)
        images, directions = kept["image"][step], kept["direction"][step]
        np.testing.assert_array_equal(ours.images(), images, f"image in step {step}")
        np.testing.assert_array_equal(vectors, vectors_of(images, directions, config), f"observation in step {step}")
        for key, mine in zip(("reward", "terminated", "truncated"), others, strict=True):
            np.testing.assert_array_equal(mine, kept[key][step], f"{key} in step {step}")
        ended = others[1] | others[2]
        if ended.any():
            ours.play_again(ended)
    hidden = int((kept["image"][..., 0] == 0).sum())
    return {"terminated": int(kept["terminated"].sum()), "truncated": int(kept["truncated"].sum()), "hidden": hidden}
