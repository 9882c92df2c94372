"""N simulations of a Scenic program as a UPOMDP, each in its own process, since Scenic's state is global.

Level and actions determine an episode. So a process that dies or hangs is restarted and replays its episode, and a
checkpoint resumes with identical results.
Read next: `episode`, which a process plays; `ued.core.upomdp`, the interface.
"""

from __future__ import annotations

import multiprocessing
import signal
import traceback
from collections.abc import Sequence
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import Any

import numpy as np

from regista.envs.scenic3.episode import Episode, Role
from regista.envs.scenic3.program import ScenicProgram
from ued.core.level_space import LevelError, check_theta
from ued.core.processes import START_METHOD, end_with_parent
from ued.core.upomdp import UPOMDP, check_count

BEGIN_SECONDS = 120.0  # time limit of a request that begins an episode; simulators may take long to start
STEP_SECONDS = 30.0  # and for each step
MOST_DEATHS = 3  # maximum deaths of processes during one request


class WorkerGoneError(Exception):
    """A process died or hung."""


class Player:
    """The work of a process: it plays the requested episodes, one at a time."""

    def __init__(self, program: ScenicProgram, role: Role) -> None:
        self.program, self.role = program, role
        self.simulator: Any = None
        self.episode: Episode | None = None

    def begin(self, theta: np.ndarray, seed: int, luck: int, actions: Sequence[Any] = ()) -> Any:
        """Begin an episode of a level, with `luck` as the seed of its randomness, and play these actions.

        Returns the initial observation, or the outcome of the last action.
        """
        if self.episode is not None:
            self.episode.close()
        if self.simulator is None:
            self.simulator = self.program.scenario.getSimulator()
        self.episode = Episode(self.program.scene(theta, seed), self.simulator, self.role, luck)
        answer = self.episode.begin()
        for action in actions:
            answer = self.episode.step(action)
        return answer

    def step(self, action: Any) -> Any:
        """Step the episode."""
        assert self.episode is not None
        return self.episode.step(action)

    def render(self) -> np.ndarray:
        """Return a picture of the episode."""
        assert self.episode is not None
        return self.episode.render()

    def serve(self, pipe: Connection, other_end: Connection) -> None:
        """Answer requests until the other end is closed; close the copy of that end that a forked process holds."""
        other_end.close()
        end_with_parent(signal.SIGKILL)  # immediately, since this process also holds the lock of a run folder
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # a Ctrl-C is for the parent, which closes this process
        signal.signal(signal.SIGTERM, signal.SIG_DFL)  # the default, whatever handler the parent has set
        with suppress(EOFError, BrokenPipeError):
            while True:
                name, *arguments = pipe.recv()
                try:
                    answer = True, getattr(self, name)(*arguments)
                except Exception as error:  # an exception of the program, its simulator or the role
                    answer = (
                        False,
                        f"{type(error).__name__}: {error}\n{''.join(traceback.format_tb(error.__traceback__, -4))}",
                    )
                pipe.send(answer)


class Worker:
    """One process with a player, and the actions of its episode."""

    def __init__(self, player: Player) -> None:
        self.player = player
        self.theta, self.seed, self.luck = np.zeros(0), 0, 0
        self.actions: list[Any] = []
        self._process: Any = None
        self._pipe: Connection | None = None

    @property
    def pid(self) -> int | None:
        """The process id; None before the start."""
        return None if self._pipe is None else self._process.pid

    def begin(self, theta: np.ndarray, seed: int, luck: int, actions: Sequence[Any] = ()) -> None:
        """Request an episode, from its start to the end of these actions."""
        self.theta, self.seed, self.luck, self.actions = theta, seed, luck, list(actions)
        self._ask("begin", theta, seed, luck, self.actions)

    def step(self, action: Any) -> None:
        """Request a step."""
        self.actions.append(action)
        self._ask("step", action)

    def answer(self) -> Any:
        """Return the answer; if the process fails, a new one replays the episode and answers.

        Raises `LevelError` if a level fails repeatedly, or if its code raises an exception.
        """
        for _ in range(MOST_DEATHS):
            try:
                well, answer = self._receive()
            except WorkerGoneError as gone:
                self.kill()
                fate = str(gone)
                self._ask("begin", self.theta, self.seed, self.luck, self.actions)
                continue
            if well:
                return answer
            raise self._error(answer)
        self.kill()
        raise self._error(f"{MOST_DEATHS} processes failed in a row: {fate}")

    def render(self) -> np.ndarray:
        """Request a picture and return it."""
        self._ask("render")
        try:
            well, answer = self._receive()
        except WorkerGoneError:
            self.kill()
            self.begin(self.theta, self.seed, self.luck, self.actions)
            self.answer()
            return self.render()
        if not well:
            raise self._error(answer)
        return answer

    def kill(self) -> None:
        """End the process."""
        if self._pipe is not None:
            self._pipe.close()
            self._process.kill()
            self._process.join()
        self._pipe = None

    def _error(self, text: str) -> LevelError:
        row = ", ".join(f"{x:.6g}" for x in self.theta)
        level = f"theta [{row}], seed {self.seed}"
        return LevelError(f"{self.player.program.file} failed after {len(self.actions)} steps ({level}): {text}")

    def _ask(self, *request: Any) -> None:
        if self._pipe is None:
            context: Any = multiprocessing.get_context(START_METHOD)  # typeshed declares no `Process` for contexts
            self._pipe, theirs = context.Pipe()
            self._process = context.Process(target=self.player.serve, args=(theirs, self._pipe), daemon=True)
            self._process.start()
            theirs.close()
        with suppress(OSError):  # the process has died: `answer` restarts it
            self._pipe.send(request)

    def _receive(self) -> Any:
        assert self._pipe is not None
        try:
            if not self._pipe.poll(BEGIN_SECONDS + STEP_SECONDS * len(self.actions)):
                raise WorkerGoneError("no answer")
            return self._pipe.recv()
        except (EOFError, OSError) as error:
            raise WorkerGoneError("it died") from error


class ScenicUPOMDP(UPOMDP):
    """N simulations of a program, in which an agent plays a role. A valid Gymnasium vector environment.

    Args:
        program: its random values are θ.
        role: the agent's observations, actions and rewards.
        num_envs: N; each environment is a process of about 200 MB, most of it shared.

    The role defines `info["success"]`. In a step in which episodes end, `info["ending"]` `[N]` is how the program ended
    each of them: "rejected" if it violated a requirement, "" if the program did not end it. Raises `LevelError`, with θ
    and seed, if a simulation or the role fails.
    """

    render_mode = "rgb_array"
    metadata: dict[str, Any] = {**UPOMDP.metadata, "render_modes": ["rgb_array"]}  # noqa: RUF012

    def __init__(self, program: ScenicProgram, role: Role, num_envs: int = 1) -> None:
        super().__init__(check_count(num_envs), role.observation_space, role.action_space, program.draws)
        self.program, self.role, self.max_episode_steps = program, role, role.max_steps
        self.workers = [Worker(Player(program, role)) for _ in range(num_envs)]
        self._observations = np.zeros((num_envs, *role.observation_space.shape), role.observation_space.dtype)

    def valid(self, theta: Any) -> np.ndarray:
        return self.program.valid(check_theta(theta, self.theta_dim))

    def describe(self, theta: Any) -> list[dict[str, Any]]:
        return [self.program.describe(row) for row in check_theta(theta, self.theta_dim)]

    def theta_of(self, values: Any) -> np.ndarray:
        """Return the θ `[D]` of values by name. Raises `ValueError` for unknown names and for values without a θ."""
        return self.program.theta_of(values)

    def _start(self, levels: np.ndarray, where: np.ndarray) -> np.ndarray:
        for level, luck, index in zip(levels, self.luck_seeds(where), where, strict=True):
            self.workers[index].begin(level["theta"].copy(), int(level["seed"]), int(luck))
        for index, seen in zip(where, self._answers(where), strict=True):
            self._observations[index] = seen
        return self._observations.copy()

    def _answers(self, where: Any) -> list[Any]:
        """Read the answers of all workers `where`, even if some fail; return them or raise the first failure.

        An answer left unread would be taken for the answer to the next request.
        """
        answers, failures = [], []
        try:
            for index in where:
                try:
                    answers.append(self.workers[index].answer())
                except LevelError as error:
                    failures.append(error)
        except BaseException:  # the wait was interrupted
            self.close_extras()
            raise
        if failures:
            raise failures[0]
        return answers

    def _advance(self, actions: Any) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        rewards, success = np.zeros(self.num_envs), np.full(self.num_envs, np.nan)
        terminated, truncated = np.zeros(self.num_envs, bool), np.zeros(self.num_envs, bool)
        endings = np.full(self.num_envs, "", object)
        playing = np.flatnonzero(~self.idle)
        for index in playing:
            self.workers[index].step(actions[index])
        for index, answer in zip(playing, self._answers(playing), strict=True):
            seen, rewards[index], terminated[index], truncated[index], result = answer
            self._observations[index] = seen
            success[index], endings[index] = float(result.get("success", np.nan)), result.get("ending", "")
        info: dict[str, Any] = {"success": success}
        if (terminated | truncated).any():
            info["ending"] = endings
        return self._observations.copy(), rewards, terminated, truncated, info

    def render(self) -> tuple[np.ndarray, ...]:
        """Return a picture of each environment, drawn by the role or else from above."""
        return tuple(worker.render() for worker in self.workers)

    # ------------------------------------------------------------ state

    def get_state(self) -> dict[str, Any]:
        """Return the levels and the actions so far; `set_state` replays them to resume the episodes."""
        return {**self.level_state(), "actions": [np.array(worker.actions) for worker in self.workers]}

    def set_state(self, state: dict[str, Any]) -> np.ndarray:
        self.set_level_state(state, "actions")
        luck = self.luck_seeds(np.arange(self.num_envs))
        rows = zip(self.workers, self.levels, luck, state["actions"], strict=True)
        for worker, level, seed, actions in rows:
            worker.begin(level["theta"].copy(), int(level["seed"]), int(seed), list(actions))
        answers = self._answers(range(self.num_envs))
        for index, (worker, answer) in enumerate(zip(self.workers, answers, strict=True)):
            self._observations[index] = answer[0] if worker.actions else answer
        return self._observations.copy()

    def resized(self, num_envs: int) -> ScenicUPOMDP:
        """Return another environment of the given size, not yet reset."""
        return ScenicUPOMDP(self.program, self.role, num_envs)

    def copy(self) -> ScenicUPOMDP:
        twin = self.resized(self.num_envs)
        twin.set_state(self.get_state())
        return twin

    def close_extras(self, **kwargs: Any) -> None:
        for worker in self.workers:
            worker.kill()
