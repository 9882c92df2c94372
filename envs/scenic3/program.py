"""A Scenic 3 program, loaded by Scenic: its random values are the columns of θ; θ and a seed determine a scene.

All other random values are drawn from the level's seed: columns excluded by name (such as colors), distributions
without a known inverse, and draws during the simulation. So θ and seed reproduce the scene.
Read next: `columns`, the primitives; `episode`, which plays a scene.
"""

from __future__ import annotations

import math
import random
import zlib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from fnmatch import fnmatch
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import scenic
from scenic.core.distributions import Options, RejectionException, Samplable
from scenic.core.lazy_eval import needsSampling
from scenic.core.scenarios import Scene
from scenic.core.utils import DefaultIdentityDict

from regista.envs.scenic3.columns import PRIMITIVES, ScenicColumn
from regista.envs.scenic3.names import Place, Places, object_names, primitive_names
from ued.core.level_space import check_theta
from ued.core.parameters import Choice, Integer, Range

COLORS = ("*color*",)  # appearance: excluded by default
MOST_TRIES = 100  # maximum number of seeds tried for a θ before it counts as invalid


class Thing(NamedTuple):
    """An object of a program: its name if it has one, its class, its behavior, and its source line."""

    name: str
    class_name: str
    behavior: str
    place: Place


class Scenes(NamedTuple):
    """The O objects of N scenes: `positions` `[N, O, 2]`, `headings` `[N, O]` in radians, validity `[N]`."""

    positions: np.ndarray
    headings: np.ndarray
    ok: np.ndarray


class Report(NamedTuple):
    """The number of sampled θ, how many of them give valid scenes, and why the others do not."""

    tried: int
    valid: int
    reasons: Counter[str]

    def __str__(self) -> str:
        lines = [f"{self.valid / self.tried:.1%} of {self.tried} uniform θ are valid scenes"]
        return "\n".join(lines + [f"  {count / self.tried:.1%} {why}" for why, count in self.reasons.most_common(8)])


class ScenicProgram:
    """A program loaded by Scenic, with θ in place of its sampler.

    Args:
        path: the `.scenic` file.
        params: global parameters that replace the program's.
        scenario: the name of the modular scenario to run; None: `Main`.
        model: the world model that replaces the program's.
        mode_2d: Scenic's 2D compatibility mode, which the driving domain needs.
        nuisance: `fnmatch` patterns such as `"*color*"`: the seed, not θ, determines the columns with matching names.

    Attributes:
        draws: the D columns of θ.
        by_seed: names of the values that the seed determines: excluded columns, and all other draws of a scene.
    """

    def __init__(
        self,
        path: str | Path,
        params: Mapping[str, Any] | None = None,
        scenario: str | None = None,
        model: str | None = None,
        mode_2d: bool = False,
        nuisance: Sequence[str] = COLORS,
    ) -> None:
        self.file = str(Path(path).resolve())
        self._settings = (self.file, dict(params or {}), scenario, model, mode_2d, tuple(nuisance))
        self._places = Places(self.file)
        with self._places.noting():
            self.scenario = scenic.scenarioFromFile(
                self.file, params=dict(params or {}), scenario=scenario, model=model, mode2D=mode_2d
            )
        self.draws: tuple[ScenicColumn, ...] = ()
        self.by_seed: list[str] = []
        self._columns: dict[int, range] = {}  # columns of θ by the id of the primitive
        self._why = ""  # reason for the rejection of the last scene
        self._lay_out(nuisance)

    def __reduce__(self) -> Any:
        return ScenicProgram, self._settings

    @property
    def dim(self) -> int:
        """D, the number of columns of θ."""
        return len(self.draws)

    @property
    def objects(self) -> list[Thing]:
        """The objects of a scene, the ego first."""
        names = object_names(self.scenario)
        return [
            Thing(
                names[id(thing)],
                type(thing).__name__,
                type(thing.behavior).__name__ if thing.behavior else "",
                self._places.of(thing),
            )
            for thing in self.scenario.objects
        ]

    # ------------------------------------------------------------ θ

    def valid(self, theta: np.ndarray) -> np.ndarray:
        """Return which rows of θ `[N, D]` give scenes that satisfy all requirements: bool `[N]`.

        Values that are not in θ are drawn from a seed derived from θ. So valid, uniform θ give the distribution of
        Scenic's scenes.
        """
        return np.array([self._try(row, _seed_of(row)) is not None for row in theta], bool)

    def scene(self, theta: np.ndarray, seed: int) -> Scene:
        """Return the scene of a row of θ `[D]` and a seed. Raises `ValueError` for an invalid θ."""
        for attempt in range(MOST_TRIES if self.by_seed else 1):
            scene = self._try(theta, zlib.crc32(f"{seed} {attempt}".encode()))
            if scene is not None:
                return scene
        scene = self._try(theta, _seed_of(theta))
        if scene is None:
            raise ValueError(f"theta {np.asarray(theta).tolist()} is not a valid scene of {self.file}: {self._why}")
        return scene

    def sample(self, count: int, rng: np.random.Generator) -> tuple[np.ndarray, int]:
        """Draw valid θ uniformly: `[count, D]`, and the number of draws, including invalid ones."""
        rows: list[np.ndarray] = []
        tries = 0
        while len(rows) < count:
            row = rng.uniform(-1, 1, self.dim)
            tries += 1
            if self.valid(row[None])[0]:
                rows.append(row)
            elif tries >= MOST_TRIES**2:
                raise ValueError(
                    f"found no valid scene of {self.file} in {tries} draws; the last was rejected: {self._why}"
                )
        return np.array(rows).reshape(count, self.dim), tries

    def instantiate(self, theta: np.ndarray) -> Scenes:
        """Return the scenes of θ `[N, D]` with the objects' positions; NaN for invalid rows."""
        scenes = [self._try(row, _seed_of(row)) for row in theta]
        places = np.full((len(theta), len(self.scenario.objects), 3), np.nan)
        for places_of, scene in zip(places, scenes, strict=True):
            for place, thing in zip(places_of, scene.objects if scene else (), strict=False):
                place[:] = thing.position.x, thing.position.y, thing.heading
        return Scenes(places[..., :2], places[..., 2], np.array([scene is not None for scene in scenes]))

    def describe(self, theta: np.ndarray) -> dict[str, Any]:
        """Return a row of θ `[D]` as values by name; NaN where a value has no unique θ."""
        values = DefaultIdentityDict()
        with seeded(_seed_of(theta)), suppress(RejectionException):
            self._sample(theta, values)
        described: dict[str, Any] = {draw.name: math.nan for draw in self.draws}
        for node in self._nodes():
            for draw in [self.draws[column] for column in self._columns.get(id(node), ()) if node in values]:
                described[draw.name] = _component(values[node], draw)
        return described

    def theta_of(self, values: Mapping[str, float]) -> np.ndarray:
        """Return the θ `[D]` of values by name. Raises `ValueError` for unknown names and for values without a θ."""
        if set(values) != {draw.name for draw in self.draws}:
            raise ValueError(f"a level needs {', '.join(draw.name for draw in self.draws)}, got {', '.join(values)}")
        theta = np.zeros(self.dim)
        for column, draw in enumerate(self.draws):
            kind = Range(draw.low, draw.high) if draw.kind == "range" and draw.low < draw.high else draw.kind
            if isinstance(kind, str):
                raise ValueError(f"{draw.name} ({kind}) is not a range with fixed ends: give θ instead of values")
            theta[column] = kind.to_unit(values[draw.name])
        return check_theta(theta, self.dim)[0]

    def report(self, count: int, rng: np.random.Generator) -> Report:
        """Return how many of `count` uniform θ are valid, and which requirements the others violate."""
        reasons: Counter[str] = Counter()
        for row in rng.uniform(-1, 1, (count, self.dim)):
            if self._try(row, _seed_of(row)) is None:
                reasons[self._why] += 1
        return Report(count, count - reasons.total(), reasons)

    # ------------------------------------------------------------ sampling

    def _try(self, theta: np.ndarray, seed: int) -> Scene | None:
        """Return the scene of θ `[D]` and this seed; None, with the reason in `_why`, if it is rejected."""
        with seeded(seed):
            for requirement in self.scenario.userRequirements:
                requirement.active = random.random() <= requirement.prob
            try:
                sample = self._sample(theta, DefaultIdentityDict())
            except RejectionException as rejection:
                self._why = str(rejection)
                return None
            broken = self.scenario.checker.checkRequirements(sample)
            if broken is not None:
                self._why = str(broken)
                return None
            return self.scenario._makeSceneFromSample(sample)

    def _sample(self, theta: np.ndarray, values: DefaultIdentityDict) -> DefaultIdentityDict:
        """Sample all random values into `values`, as `Samplable.sampleAll` does; θ `[D]` determines the primitives."""
        shares = ((np.asarray(theta, float) + 1) / 2).tolist()
        for root in self.scenario.dependencies:
            self._fill(root, shares, values)
        return values

    def _fill(self, node: Any, shares: list[float], values: DefaultIdentityDict) -> None:
        if node in values:
            return
        if not needsSampling(node):
            values[node] = node
            return
        actual = node._conditioned  # set by pruning: an equivalent distribution with more valid samples
        for child in actual._dependencies:
            self._fill(child, shares, values)
        at = self._columns.get(id(node))
        if at is None:
            values[node] = actual.sampleGiven(values)
        else:
            values[node] = PRIMITIVES[type(actual)][1](actual, values, *shares[at.start : at.stop])

    # ------------------------------------------------------------ finding the columns

    def _nodes(self) -> Iterator[Samplable]:
        """Yield all random values of a scene, dependencies first."""
        known: set[int] = set()

        def walk(node: Any) -> Iterator[Samplable]:
            if id(node) not in known and needsSampling(node):
                known.add(id(node))
                for child in node._conditioned._dependencies:
                    yield from walk(child)
                yield node

        for root in self.scenario.dependencies:
            yield from walk(root)

    def _lay_out(self, nuisance: Sequence[str]) -> None:
        """Assign columns to the random primitives, in the order in which the program creates them."""
        names, nodes = primitive_names(self.scenario) | object_names(self.scenario), list(self._nodes())
        labels = {id(node.index): node.options for node in nodes if isinstance(node, Options)}
        uses: Counter[str] = Counter()
        for node in self._places.order([node for node in nodes if type(node._conditioned) in PRIMITIVES]):
            place, parts = self._places.of(node), PRIMITIVES[type(node._conditioned)][0](node._conditioned)
            name = names.get(id(node), f"{type(node).__name__} of line {place.line}")
            if not parts or any(fnmatch(name, pattern) for pattern in nuisance):
                self.by_seed.append(name)
                continue
            uses[name] += 1
            name += f"[{uses[name]}]" * (uses[name] > 1)
            self._columns[id(node)] = range(self.dim, self.dim + len(parts))
            for part in parts:
                kind = part.kind
                if id(node) in labels and isinstance(kind, Integer):
                    kind = Choice(*(_label(option) for option in labels[id(node)]))
                self.draws += (ScenicColumn(name + part.suffix, kind, part.low, part.high, place),)
        self.by_seed += [f"require[{each.prob:g}]" for each in self.scenario.userRequirements if each.prob < 1]
        self.by_seed = list(dict.fromkeys(self.by_seed + self._other_chance(names)))

    def _other_chance(self, names: Mapping[int, str]) -> list[str]:
        """Return the names of all other random draws of a scene: mutations, and distributions of other packages."""
        values, found = DefaultIdentityDict(), []
        with seeded(0):
            for node in self._nodes():
                before = _streams()
                with suppress(RejectionException):
                    self._fill(node, [0.5] * self.dim, values)
                if _streams() != before and type(node._conditioned) not in PRIMITIVES:
                    found.append(names.get(id(node), type(node).__name__))
        return found


@contextmanager
def seeded(seed: int) -> Iterator[None]:
    """Seed Scenic's draws inside the context; Python's and NumPy's global streams are restored afterwards."""
    before = random.getstate(), np.random.get_state()
    random.seed(seed)
    np.random.seed(seed % 2**32)
    try:
        yield
    finally:
        random.setstate(before[0])
        np.random.set_state(before[1])


def _streams() -> tuple[Any, int]:
    """Return the state of the global random streams, which changes with each draw."""
    state: Any = np.random.get_state()
    return random.getstate(), state[2]


def _seed_of(theta: np.ndarray) -> int:
    return zlib.crc32(np.ascontiguousarray(theta, float).tobytes())


def _label(option: Any) -> str:
    return "random" if needsSampling(option) else str(option)


def _component(value: Any, draw: ScenicColumn) -> Any:
    """Return how a primitive's value depends on one of its columns."""
    if value is None:
        return math.nan
    if isinstance(draw.kind, Choice):
        return draw.kind.values[value]
    axis = draw.kind.partition("point.")[2] if isinstance(draw.kind, str) else ""
    if axis == "along":
        return f"({value.x:.4g}, {value.y:.4g})"
    return float(getattr(value, axis)) if axis else value
