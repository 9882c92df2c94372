"""Mazes as a UPOMDP: N agents in N mazes, stepped as one batch.

Read next: `levels`, the space of mazes; `dynamics`, a step; `rollout`, whole rollouts at once.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.spaces import Box, Dict, Discrete

from regista.envs.maze.config import MazeConfig
from regista.envs.maze.dynamics import step_mazes
from regista.envs.maze.grid import (
    BORDER,
    DIRECTIONS,
    UNSEEN,
    Agents,
    Layouts,
    Outcome,
    Settings,
    empty_layouts,
    width_of,
)
from regista.envs.maze.levels import Maze, MazeFamily, check_maze
from regista.envs.maze.paths import UNREACHABLE, path_lengths
from regista.envs.maze.picture import draw_maze, view_entries
from regista.envs.maze.rollout import play_mazes
from regista.envs.maze.view import CELLS, CHANNELS, IMAGE_SCALE, VIEW, image_shape, observe_all, write_images
from regista.kernels.calls import compiles
from ued.core.begun import check_begun
from ued.core.compiled import CompiledRollout
from ued.core.level_space import check_theta
from ued.core.parameters import ThetaMap
from ued.core.parts import Parts
from ued.core.upomdp import UPOMDP, check_count

NUM_ACTIONS = 3
FACING = ("right", "down", "left", "up")
MOST_CLOCK = 2**31  # in a state; the clock counts on after the end of an episode until the next one starts


class Mazes(UPOMDP):
    """N partially observed mazes; the docstring of the package lists their properties and sources.

    Args:
        num_envs: N.
        config: size, random mazes, time limit, view.
        render_mode: None or "rgb_array".

    Observations are vectors `[N, F]`, float32 in [0, 1]: an image and the direction (see `view`, `ued.core.parts`). The
    network that reads them is an MLP, or a CNN if `PPOConfig.network` is "cnn". Actions `[N]` are 0 turn left, 1 turn
    right, 2 forward. An episode is terminated at the goal and truncated after `max_steps`. As in MiniGrid, it is both
    terminated and truncated if the agent reaches the goal in the last step. `info["success"]` `[N]` is 1 where the
    agent has reached the goal in this step. The level and the agent's actions fully determine an episode.
    """

    seed_is_luck = True  # θ fully determines the maze

    metadata: dict[str, Any] = {**UPOMDP.metadata, "render_modes": ["rgb_array"], "render_fps": 10}  # noqa: RUF012

    def __init__(
        self,
        num_envs: int = 32,
        config: MazeConfig = MazeConfig(),  # noqa: B008 (frozen)
        render_mode: str | None = None,
    ) -> None:
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise ValueError(f"render_mode must be None or 'rgb_array', not {render_mode!r}")
        self.config, count, self.render_mode = config, check_count(num_envs), render_mode
        self.level_family = self._family = MazeFamily(
            config.side, config.num_walls, config.random_count, config.goal_last
        )
        self.theta_map = ThetaMap(self._family)
        as_image = config.representation == "image"
        self._settings = Settings(width_of(config.side), config.max_steps, bool(config.see_through), as_image)
        seen = parts_of(config.see_through, as_image)
        super().__init__(count, seen, Discrete(NUM_ACTIONS), self.theta_map.draws)
        self._size = seen.shape[0]
        self.max_episode_steps = config.max_steps
        self._layouts = empty_layouts(count, config.side)
        self._agents = Agents(self._layouts.start.copy(), *(np.zeros(count, np.int64) for _ in range(2)))
        self._outcome = Outcome(np.zeros(count), *(np.zeros(count, np.bool_) for _ in range(2)))
        self._pool = empty_layouts(0, config.side)
        self._begun = np.zeros(count, bool)

    @property
    def layouts(self) -> Layouts:
        """The current mazes, `[N]`; read-only."""
        return self._layouts

    @property
    def agents(self) -> Agents:
        """The positions of the agents, `[N]`; read-only."""
        return self._agents

    @property
    def width(self) -> int:
        """Entries per side of the grids of `layouts`."""
        return self._settings.width

    @property
    def observation_scale(self) -> np.ndarray:
        return np.full(self._size, 1 / IMAGE_SCALE if self._settings.as_image else 1.0)

    def valid(self, theta: Any) -> np.ndarray:
        """Return whether start and goal differ in each maze of θ `[K, D]`: bool `[K]`."""
        return self._family.valid(check_theta(theta, self.theta_dim))

    def theta_of(self, maze: Maze) -> np.ndarray:
        """Return the θ `[D]` of a maze. Raises ValueError for a wrong size, and for positions outside the maze."""
        check_maze(maze, self.config.side)
        return self._family.encode(maze)

    def describe(self, theta: Any) -> list[dict[str, Any]]:
        """Describe the mazes of θ `[K, D]` by name: walls, agent, goal, and the length of the shortest path."""
        layouts = self.layouts_of(theta)
        described = []
        for row, steps in zip(theta, path_lengths(layouts, self.width), strict=True):
            maze = self._family.decode(np.asarray(row))
            described.append(
                {
                    "walls": int(maze.walls.sum()),
                    "agent": f"{_cell(maze.start)} facing {FACING[maze.direction]}",
                    "goal": _cell(maze.goal),
                    "shortest path": "none" if steps == UNREACHABLE else f"{steps} steps",
                }
            )
        return described

    def layouts_of(self, theta: Any) -> Layouts:
        """Return the mazes of θ `[K, D]` as arrays."""
        return self._family.layouts(check_theta(theta, self.theta_dim))

    def _draw(self, count: int) -> np.ndarray:
        return self._family.draw_codes(self._stream, count)

    # ------------------------------------------------------------ episodes

    def _start(self, levels: np.ndarray, where: np.ndarray) -> np.ndarray:
        for target, source in zip(self._layouts, self._family.layouts(levels["theta"]), strict=True):
            target[where] = source
        return self._begin(where)

    def play_again(self, where: np.ndarray | None = None) -> np.ndarray:
        chosen = np.flatnonzero(self._mask(where))  # their mazes are in the batch
        check_begun(self._begun[chosen], "starting another episode")
        self.episodes[chosen] += 1
        return self._begin(chosen)

    def _begin(self, where: np.ndarray) -> np.ndarray:
        """Put the agents of the environments `where` `[k]` at the start of their mazes; return all observations."""
        agents, layouts = self._agents, self._layouts
        agents.at[where], agents.direction[where] = layouts.start[where], layouts.direction[where]
        agents.clock[where] = 0
        self._begun[where] = True
        return self.observe()

    def _advance(self, actions: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        check_begun(self._begun | self.idle, "step()")
        seen, out = np.empty((self.num_envs, self._size), np.float32), self._outcome
        step_mazes(self._layouts, self._agents, self._settings, self._checked(actions), out, seen)
        success = {"success": out.terminated.astype(float)}
        return seen, out.reward.copy(), out.terminated.copy(), out.truncated.copy(), success

    def _checked(self, actions: Any) -> np.ndarray:
        """Return actions as int64 `[N]`. Raises ValueError for another shape or type, or an unknown action."""
        array = np.asarray(actions)
        if array.shape != (self.num_envs,) or array.dtype.kind not in "iu":
            raise ValueError(f"actions must be {self.num_envs} integers, got shape {array.shape} of {array.dtype}")
        if array.min() < 0 or array.max() >= NUM_ACTIONS:
            wrong = array[(array < 0) | (array >= NUM_ACTIONS)][0]
            raise ValueError(f"action {wrong} does not exist; actions are 0 to {NUM_ACTIONS - 1}")
        return np.require(array, np.int64, ("C", "W"))  # kernels would be compiled again for another memory layout

    def observe(self) -> np.ndarray:
        """Return the current observations in a new array, `[N, F]`."""
        seen = np.empty((self.num_envs, self._size), np.float32)
        observe_all(self._layouts, self._agents, self._settings, seen)
        return seen

    def images(self) -> np.ndarray:
        """Return the current views in MiniGrid's encoding: object, color and state, uint8 `[N, 5, 5, 3]`.

        The last three axes are the column from the left, the row from the top, and the channel.
        """
        images = np.empty((self.num_envs, CHANNELS * CELLS), np.uint8)
        write_images(self._layouts, self._agents, self._settings, images)
        return images.reshape(-1, VIEW, VIEW, CHANNELS)

    def directions(self) -> np.ndarray:
        """Return the directions that the agents face: 0 right, 1 down, 2 left, 3 up, int `[N]`."""
        return self._agents.direction.copy()

    def render(self) -> tuple[np.ndarray, ...] | None:
        """Return a picture of each maze, uint8 `[pixels, pixels, 3]` (see `picture`); None without a render mode."""
        if self.render_mode is None:
            return None
        agents, seen = zip(self._agents.at.tolist(), self._agents.direction.tolist(), strict=True), self.seen()
        rows = zip(self._layouts.grid, agents, seen, strict=True)
        return tuple(draw_maze(grid, *agent, entries) for grid, agent, entries in rows)

    def seen(self) -> list[np.ndarray]:
        """Return one array per agent: the grid entries in its view that walls do not hide."""
        things = self.images()[..., 0].reshape(self.num_envs, CELLS)
        agents = zip(things, self._agents.at.tolist(), self._agents.direction.tolist(), strict=True)
        return [view_entries(at, direction, self.width)[view != UNSEEN] for view, at, direction in agents]

    # ------------------------------------------------------------ rollouts

    @property
    def plays_rollouts(self) -> bool:
        return compiles()

    def _prepare(self, levels: np.ndarray) -> np.ndarray:
        self._pool = self._family.layouts(levels["theta"])
        return np.where(self._family.valid(levels["theta"]), np.arange(len(levels)), -1)

    def _play(self, rollout: CompiledRollout) -> None:
        play_mazes(rollout, self._layouts, self._agents, self._pool, self._settings)

    # ------------------------------------------------------------ state

    def get_state(self) -> dict[str, Any]:
        """Return the full state; `set_state` derives the mazes from the levels."""
        return {**self.level_state(), **{name: array.copy() for name, array in self._agents._asdict().items()}}

    def set_state(self, state: dict[str, Any]) -> np.ndarray:
        """Restore what `get_state` returned; return the observations of that state `[N, F]`.

        Raises ValueError for a state that does not fit; the environment is then unchanged.
        """
        agents = {name: state.get(name) if isinstance(state, dict) else None for name in Agents._fields}
        for name, array in agents.items():
            if array is not None:
                self._check_agents(name, array)
        self.set_level_state(state, *Agents._fields)
        for target, source in zip(self._layouts, self._family.layouts(self.levels["theta"]), strict=True):
            target[:] = source
        for name, array in agents.items():
            getattr(self._agents, name)[:] = array
        self._begun[:] = True
        return self.observe()

    def _check_agents(self, name: str, array: Any) -> None:
        """Raise ValueError unless this is an array of `Agents` with values that kernels can read."""
        most = {"direction": DIRECTIONS - 1, "clock": MOST_CLOCK}.get(name, self._layouts.grid.shape[1] - 1)
        if not isinstance(array, np.ndarray) or array.shape != (self.num_envs,) or array.dtype != np.int64:
            raise ValueError(f"{name} of a state must be {self.num_envs} integers of 64 bits, got {array!r:.100}")
        if array.min() < 0 or array.max() > most:
            raise ValueError(f"{name} of a state must be from 0 to {most}, got {array.min()} to {array.max()}")
        inside = np.stack(np.divmod(array, self._settings.width)) - BORDER
        if name == "at" and (inside.min() < 0 or inside.max() >= self.config.side):
            raise ValueError(f"at of a state must be cells of the maze, without its border, got {array!r:.100}")

    def copy(self) -> Mazes:
        """Return an independent environment in the same state."""
        twin = Mazes(self.num_envs, self.config, self.render_mode)
        twin.set_state(self.get_state())
        twin._begun[:] = self._begun
        return twin


def parts_of(see_through: bool, as_image: bool) -> Parts:
    """Return the space of observations: an image of the view, and the direction."""
    image = Box(0.0, 1.0, image_shape(see_through, as_image), np.float32)
    return Parts(Dict([("image", image), ("direction", Discrete(DIRECTIONS))]), network="mlp")


def _cell(place: tuple[int, int]) -> str:
    return f"row {place[0]} column {place[1]}"
