"""Short football matches, and what came of them: what holds a version of the simulator.

A scene is a program that is played in a few rows. The agents' actions, the luck, and where exactly everybody starts
follow from the seed of the row, by Python's `random.random`, which is the same in all versions of Python. Scenes and
what came of them are kept in `played.npz`, programs as text: a change of whoever drew them changes nothing. Read next:
`lab/record_football.py`, which writes that file; `test_simulator_version.py`, which says how far it holds.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from random import Random
from typing import Any, NamedTuple

import numpy as np

from regista.envs.football.config import FootballConfig
from regista.envs.football.vector_env import FootballVectorEnv

FILE = Path(__file__).parent / "played.npz"
EVERY = 10  # steps between two of which digests are kept
TOLERANCE, RESOLUTION = 1e-5, 1e-6  # m of a digest: by how much it may differ, and how exactly it is kept
LEFT_COUNTS = 100  # in the fact "cards": more than all cards, of a player who has been sent off and is gone
LETTERS = "abcdefghijklmnopqrs"  # the 19 actions
FACTS = ("mode", "carrier", "last touch", "owner", "left goals", "right goals", "cards", "agents", "ended", "success")
DIGESTS = ("place of the ball", "places of the players", "observations", "rewards")


@dataclass(frozen=True)
class Scene:
    """What is played.

    Attributes:
        name: what it is called.
        program: its text; nothing in it is random.
        settings: of `FootballConfig`.
        steps: T, a multiple of EVERY.
        urn: letters from which actions are drawn, one for each of the 19; a letter that comes twice is twice as likely.
        hold: how often an agent repeats its last action.
        spread: m, by which everybody and the ball start elsewhere than the program says, at most.
        start: fields that differ at the start: of the match, of the ball as `ball.vx`, of player k as `k.x`; the ends
            of a range.
        scripted: program and built-in AI play the agents' players, too, and actions mean nothing.
        seeds: of the R rows.
    """

    name: str
    program: str
    settings: dict[str, Any]
    steps: int
    urn: str
    hold: float
    spread: float
    start: dict[str, Sequence[float]]
    scripted: bool
    seeds: tuple[int, ...]

    def actions(self, agents: int) -> np.ndarray:
        """Return the actions, int64 `[T, R, A]`."""
        chosen = np.zeros((self.steps, len(self.seeds), agents), np.int64)
        for row, seed in enumerate(self.seeds):
            rng = Random(seed)
            for step in range(self.steps):
                for agent in range(agents):
                    kept, drawn = rng.random() < self.hold, int(rng.random() * len(self.urn))
                    action = LETTERS.index(self.urn[drawn])
                    chosen[step, row, agent] = chosen[step - 1, row, agent] if step and kept else action
        return chosen

    def place(self, matches: np.ndarray) -> None:
        """Let matches MATCH `[R]` that are about to begin start as the rows do."""
        count = int(matches["num_players"][0])
        for row, seed in enumerate(self.seeds):
            rng = Random(seed + 1)
            for axis in "xy":
                for k in range(count):
                    away = self.spread * (2.0 * rng.random() - 1.0)
                    for name in (axis, f"start_{axis}"):  # to the latter they return after a goal
                        matches["players"][name][row, k] += away
                matches["ball"][axis][row] += self.spread * (2.0 * rng.random() - 1.0)
            for name, (low, high) in self.start.items():
                whose, _, field = name.rpartition(".")
                things = matches["ball"] if whose == "ball" else matches["players"][:, int(whose)] if whose else matches
                things[field][row] = low + (high - low) * rng.random()


class Play(NamedTuple):
    """What came of a scene in R rows: after each step what is exact, every few steps what is nearly so."""

    facts: np.ndarray  # [T, R, F] int64, see FACTS
    digests: np.ndarray  # [T / EVERY, R, D] float64, see DIGESTS


class Change(NamedTuple):
    """Where a row is played otherwise than it was: at which step, in which respect, by how much."""

    row: int
    step: int
    what: str
    was: float
    now: float

    def __str__(self) -> str:
        return f"row {self.row}, step {self.step}: {self.what} was {self.was:.6g}, is {self.now:.6g}"


@dataclass(frozen=True)
class Kept:
    """A scene as it was played: `facts` and `digests` as in `Play`, of each row until step `steady` `[R]`."""

    scene: Scene
    facts: np.ndarray
    digests: np.ndarray
    steady: np.ndarray

    def changes(self, play: Play) -> list[Change]:
        """Return where it is played otherwise now: the first change of each row that has one."""
        return [change for row in range(len(self.steady)) if (change := self._change(play, row))]

    def _change(self, play: Play, row: int) -> Change | None:
        until = int(self.steady[row])
        facts = np.argwhere(self.facts[:until, row] != play.facts[:until, row])
        off = np.abs(self.digests[: until // EVERY, row] - play.digests[: until // EVERY, row])
        digests = np.argwhere(~(off <= TOLERANCE))  # what is no number is off, too
        found = []
        if len(facts):
            step, k = facts[0]
            found.append(Change(row, step + 1, FACTS[k], self.facts[step, row, k], play.facts[step, row, k]))
        if len(digests):
            at, k = digests[0]
            was, now = self.digests[at, row, k], play.digests[at, row, k]
            found.append(Change(row, (at + 1) * EVERY, DIGESTS[k], was, now))
        return min(found, key=lambda change: change.step, default=None)


def play(scene: Scene, copies: int = 1, disturb: Callable[[np.ndarray, int], None] | None = None) -> Play:
    """Play a scene; with `copies`, all rows so many times, one after the other in one batch.

    `disturb` is given the matches MATCH `[copies * R]` at the start and after each step, with its number from 0 on, and
    may change them.
    """
    env = make_env(scene, copies)
    actions = np.tile(scene.actions(env.num_agents), (1, copies, 1)).reshape(scene.steps, *env.action_space.shape)
    matches = env._batch.matches
    facts, digests, paid = [], [], np.zeros(env.num_envs)
    for step in range(scene.steps):
        if disturb is not None:
            disturb(matches, step)
        seen, rewards, _, _, info = env.advance(actions[step])
        paid += rewards
        facts.append(facts_of(matches, info["success"]))
        if (step + 1) % EVERY == 0:
            digests.append(digest_of(matches, seen, paid))
    return Play(np.array(facts), np.array(digests))


def make_env(scene: Scene, copies: int = 1) -> FootballVectorEnv:
    """Return the environment at the start of a scene."""
    rows = len(scene.seeds)
    env = FootballVectorEnv(scene.program, rows * copies, config=FootballConfig(**scene.settings))
    levels = env.make_levels(np.zeros((rows * copies, env.theta_dim)))
    levels["seed"] = np.tile(scene.seeds, copies)
    env.reset_to_levels(levels)
    env.scripted = scene.scripted
    for copy in range(copies):
        scene.place(env._batch.matches[copy * rows :][:rows])
    return env


def facts_of(matches: np.ndarray, success: np.ndarray) -> np.ndarray:
    """Return what is exact of matches MATCH `[N]`, and of their `success` `[N]`: int64 `[N, F]`."""
    agents = matches["agents"].astype(np.int64) @ (np.arange(matches["agents"].shape[1]) ** 2 + 1)
    names = ("game_mode", "carrier", "last_touch", "reported_owner")
    cards = matches["players"]["cards"].sum(1) + LEFT_COUNTS * matches["players"]["has_left"].sum(1)
    columns = [*(matches[name] for name in names), *matches["score"].T, cards]
    return np.stack([*columns, agents, matches["ended"], success], 1).astype(np.int64)


def digest_of(matches: np.ndarray, seen: np.ndarray, paid: np.ndarray) -> np.ndarray:
    """Return what is nearly exact of matches MATCH `[N]`: `[N, D]`.

    Each is a mean in which every number has a weight of its own, so that it tells if any of them is another.
    """
    players = matches["players"][:, : matches["num_players"][0]]
    ball = np.stack([matches["ball"][axis] for axis in "xyz"], 1)
    places = np.concatenate([players[axis] for axis in "xy"], 1)
    return np.stack([*map(weighted, (ball, places, seen.reshape(len(seen), -1))), paid], 1)


def weighted(values: np.ndarray) -> np.ndarray:
    """Return a mean of numbers `[N, K]`, weighted from 1 to 2: `[N]`."""
    return (values * np.linspace(1.0, 2.0, values.shape[1])).mean(1)


# ---------------------------------------------------------------- the file


def load(path: Path = FILE) -> tuple[int, list[Kept]]:
    """Return of which version of the simulator a file is, and its scenes as they were played."""
    with np.load(path, allow_pickle=False) as archive:
        arrays = {name: archive[name] for name in archive.files}
    kept, at = [], dict.fromkeys(("steady", "facts", "digests"), 0)
    for each in json.loads(str(arrays["scenes"])):
        scene = Scene(**each | {"seeds": tuple(each["seeds"])})
        rows = len(scene.seeds)
        lengths = {"steady": 1, "facts": scene.steps, "digests": scene.steps // EVERY}
        parts = {name: arrays[name][at[name] :][: rows * length] for name, length in lengths.items()}
        at = {name: at[name] + rows * length for name, length in lengths.items()}
        facts = parts["facts"].astype(np.int64).reshape(-1, rows, len(FACTS)).cumsum(0)
        digests = parts["digests"].reshape(-1, rows, len(DIGESTS)).cumsum(0) * RESOLUTION
        kept.append(Kept(scene, facts, digests, parts["steady"]))
    return int(arrays["version"]), kept


def save(version: int, kept: Sequence[Kept], path: Path = FILE) -> None:
    """Write a file: differences from one moment to the next, which are small; nothing of what is not compared."""
    whole = [shortened(one) for one in kept]
    np.savez_compressed(
        path,
        version=version,
        scenes=json.dumps([asdict(one.scene) for one in whole]),
        steady=np.concatenate([one.steady for one in whole]).astype(np.int16),
        facts=np.concatenate([differences(one.facts) for one in whole]).astype(np.int32),
        digests=np.concatenate([differences(np.rint(one.digests / RESOLUTION)) for one in whole]).astype(np.int64),
    )


def shortened(kept: Kept) -> Kept:
    """Return a scene as it was played, with its last steady moment in the place of all later ones."""
    facts, digests = kept.facts.copy(), kept.digests.copy()
    for row, until in enumerate(kept.steady.tolist()):
        facts[until:, row], digests[until // EVERY :, row] = facts[until - 1, row], digests[until // EVERY - 1, row]
    return replace(kept, facts=facts, digests=digests)


def differences(array: np.ndarray) -> np.ndarray:
    """Return differences along the first axis, the rows of which are put one below the other."""
    return np.diff(array, axis=0, prepend=0).reshape(-1, array.shape[-1])
