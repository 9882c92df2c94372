"""Do our mazes play like MiniGrid's? The same random mazes and actions in both, with every step compared.

The comparison is exact: the image of the view, the direction, the reward, termination and truncation. Settings are the
benchmark's, with see-through walls and with walls that hide what is behind them, and mazes of other sizes. With
minigrid 3.2.0 all of them are equal. It needs `pip install minigrid`:

    python -m lab.maze_minigrid --mazes 1000 --steps 100
"""

from __future__ import annotations

import argparse
import time

from regista.envs.maze.config import MazeConfig
from tests.envs.minigrid_maze import compare

CONFIGS = {
    "25 walls": MazeConfig(),
    "25 walls, walls hide": MazeConfig(see_through=False),
    "0 to 59 walls": MazeConfig(num_walls=60, random_count=True),
    "0 to 59 walls, walls hide": MazeConfig(num_walls=60, random_count=True, see_through=False),
    "5 x 5 cells, 20 steps, walls hide": MazeConfig(side=5, num_walls=6, max_steps=20, see_through=False),
    "19 x 19 cells, 150 walls, walls hide": MazeConfig(side=19, num_walls=150, see_through=False),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mazes", type=int, default=1000, help="random mazes of each setting")
    parser.add_argument("--steps", type=int, default=100, help="steps in each maze")
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    for name, config in CONFIGS.items():
        began = time.process_time()
        counts = compare(config, arguments.mazes, arguments.steps, arguments.seed)
        found = ", ".join(f"{count:,} {what}" for what, count in counts.items())
        print(f"{name}: equal; {found}; {time.process_time() - began:.0f} s", flush=True)


if __name__ == "__main__":
    main()
