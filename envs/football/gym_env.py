"""One football match as a standard Gymnasium environment: a batch of one.

Read next: `vector_env`, which does the work.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np

from regista.envs.football.config import FootballConfig
from regista.envs.football.constants import DURATION, GOAL, OUT_OF_PLAY, POSSESSION, REJECTED, RUNNING, TERMINATED
from regista.envs.football.observation.raw import row
from regista.envs.football.vector_env import FootballVectorEnv
from regista.envs.football.view.picture import draw_match
from scenic_lite import Program

ENDINGS = {
    RUNNING: "",
    GOAL: "goal",
    OUT_OF_PLAY: "out of play",
    POSSESSION: "possession change",
    DURATION: "duration",
    TERMINATED: "terminated by the program",
    REJECTED: "rejected by the program",
}


class FootballEnv(gymnasium.Env):
    """One match. Each `reset` samples a new level, or uses θ `[D]` in [-1, 1] from `options={"theta": θ}`.

    Args:
        program: a compiled program, the path of one, or its text.
        representation: the observation: "features", "simple115", "smm", "smm_stacked", "raw" (see `observation`).
        rewards: "scoring" or "scoring,checkpoints".
        control, right_control: the players of the left and right team that agents move (see `control_modes`).
        render_mode: None or "rgb_array".
        dialect: 2 or 3, the Scenic version of a program given as text or path; None: detected (see `scenic_lite.load`).
        engine: "regista", or "grf" for Google Research Football, run by the Python `grf_python` (see `FootballConfig`).

    After a reset, `info["theta"]` is the θ of the level, and `info["replaced"]` is true if a valid θ replaces an
    invalid one. After a step, `info["ended"]` is the reason why the episode ended ("" while it runs). With several
    agents, `info["agent_rewards"]` `[A]` holds each agent's reward. If the program has `record` statements,
    `info["records"]` holds the values recorded in the step, by name.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 10}  # noqa: RUF012

    def __init__(
        self,
        program: Program | str | Path,
        representation: str = "features",
        rewards: str = "scoring",
        control: str = "closest1",
        right_control: str = "none",
        render_mode: str | None = None,
        dialect: int | None = None,
        engine: str = "regista",
        grf_python: str | None = None,
    ) -> None:
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise ValueError(f"render_mode must be None or 'rgb_array', not {render_mode!r}")
        self.render_mode = render_mode
        config = FootballConfig(
            representation, rewards, control, right_control, dialect, engine=engine, grf_python=grf_python
        )
        self.batch = FootballVectorEnv(program, 1, config=config)
        self.observation_space = self.batch.single_observation_space
        self.action_space = self.batch.single_action_space
        self.theta_space, self.parameters = self.batch.theta_space, self.batch.parameters

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Start a match.

        Raises:
            ued.core.upomdp.ThetaError: an invalid θ.
            ValueError: other options.
        """
        super().reset(seed=seed)
        given = {**(options or {})}
        if "theta" in given:
            given["theta"] = [given["theta"]]
        observations, info = self.batch.reset(seed=seed, options=given)
        return self._first(observations), {"theta": info["levels"]["theta"][0], "replaced": bool(info["replaced"][0])}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Step the match by 0.1 s.

        Raises:
            ValueError: an action that is not a whole number from 0 to 18, or a wrong number of actions.
            RuntimeError: before `reset`.
        """
        observations, rewards, terminated, truncated, info = self.batch.advance(np.array([action]))
        own: dict[str, Any] = {"ended": ENDINGS[int(info["ended"][0])]}
        if self.batch.num_agents > 1:
            own["agent_rewards"] = info["agent_rewards"][0]
        if "records" in info:
            own["records"] = {name: values[0] for name, values in info["records"].items() if is_there(values[0])}
        return self._first(observations), float(rewards[0]), bool(terminated[0]), bool(truncated[0]), own

    def reset_random(self) -> Any:
        """Sample all environment parameters uniformly and reset (thesis, section 4.2); return the observation."""
        return self.reset()[0]

    def step_adversary(self, theta: Any) -> tuple[Any, dict[str, Any]]:
        """Set the environment parameters to θ `[D]` and reset (thesis, section 4.2)."""
        return self.reset(options={"theta": theta})

    def reset_agent(self) -> Any:
        """Start a new episode on the same level; return the observation."""
        return self._first(self.batch.reset_agent())

    def render(self) -> np.ndarray | None:
        """Return the match as a picture, uint8 `[height, width, 3]` (see `picture`); None without a render mode.

        After the last step of an episode, the picture shows the end of that episode.
        """
        if not self.render_mode:
            return None
        return draw_match(self.batch.matches[0])

    def close(self) -> None:
        """Free the engine's resources."""
        self.batch.close()

    def get_state(self) -> dict[str, Any]:
        """Return the full state, as arrays and plain values; `set_state` resumes from it bit for bit."""
        return self.batch.get_state()

    def set_state(self, state: dict[str, Any]) -> Any:
        """Restore what `get_state` returned; return the observation of that state.

        Raises:
            ValueError: a state of another match: see `FootballVectorEnv.set_state`.
        """
        return self._first(self.batch.set_state(state))

    def _first(self, observations: Any) -> Any:
        """Return row 0 of a batch; for `raw` a dict with GRF's types, or a tuple of dicts for several agents."""
        if isinstance(observations, tuple):
            return tuple(row(part, 0) for part in observations)
        return row(observations, 0) if isinstance(observations, dict) else observations[0]


def is_there(value: Any) -> bool:
    """Return whether a value was recorded: a missing vector or number is NaN, another missing value is None."""
    return value is not None and not (isinstance(value, float | np.ndarray) and bool(np.isnan(value).any()))
