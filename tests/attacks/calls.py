"""Calls of environments with arguments that they should not have: refused in a sentence, or carried out without harm.

After each call the environment must play the same match as one that nobody had called. Read next: `options`, what
is typed on the command line.
"""

from __future__ import annotations

import copy
import random
import sys
import time
from collections.abc import Callable
from functools import cache
from typing import Any

import gymnasium
import numpy as np

import ued
from regista.envs.football.vector_env import FootballVectorEnv
from regista.minigames import MINIGAMES
from tests.envs.hostile import NUMBERS, WORDS
from ued.probes import Frontier

DONE, REFUSED = "carried out", "refused in a sentence"
SECONDS = 2.0  # of processor time, at most, for a call and what is played after it
# and what is derived from them; Gymnasium has one of its own for a seed that is none
ERRORS = (ValueError, TypeError, ued.LevelError, gymnasium.error.Error)
STEPS, NUM_ENVS = 3, 3
TYPES = (np.float64, np.float32, np.int64, np.uint8, np.bool_, np.complex128, object, "U5")
FEW = [word for word in WORDS.tolist() if word < 1_000]  # for some are asked for as many levels
STRANGE: list[Any] = [
    *(None, True, -1, 0, 1, 2, 3, 0.5, 10**30, 1j, float("nan"), float("inf"), "", "x", b"x", [], {}, (), set()),
    *([[]], [[[1]]], {"theta": 1}, [None] * NUM_ENVS, ["a"] * NUM_ENVS, [True] * NUM_ENVS, object(), len, iter(())),
]


def pendulum() -> ued.GymUPOMDP:
    """Return an environment of others under an adversary."""
    columns = {"g": ued.LogRange(1.0, 20.0), "l": ued.Choice(0.5, 1.0, 2.0)}

    def apply(env: Any, values: Any) -> None:
        vars(env.unwrapped).update(values)

    return ued.GymUPOMDP(lambda: gymnasium.make("Pendulum-v1"), apply, columns, NUM_ENVS)


MADE: dict[str, Callable[[], Any]] = {
    "probe": lambda: Frontier(NUM_ENVS, 5, 2),
    "pendulum": pendulum,
    "football": lambda: FootballVectorEnv(MINIGAMES["1v1Free"].program, NUM_ENVS),
}


class Target:
    """An environment, what it plays if nobody calls it, and arguments that are good."""

    def __init__(self, make: Callable[[], Any]) -> None:
        self.env = make()
        self.env.reset(seed=0)
        self.actions = [self.env.action_space.sample() for _ in range(STEPS)]
        self.played = self.play()
        theta, levels = self.env.sample_theta(NUM_ENVS), self.env.sample_levels(NUM_ENVS)
        mask = np.array([True, False, True])
        state = {"set_state": (self.env.get_state(),)} if self.env.supports_state else {}
        self.good: dict[str, tuple[Any, ...]] = state | {
            "step": (self.actions[0],),
            "reset": (7, {"theta": theta}),
            "reset_to_levels": (levels[:2], mask),
            "make_levels": (theta,),
            "valid": (theta,),
            "describe": (theta,),
            "sample_levels": (4,),
            "sample_theta": (4,),
            "step_adversary": (theta,),
        }

    def play(self) -> bytes:
        """Return what is seen in some steps of a match that begins anew."""
        seen, _ = self.env.reset(seed=0)
        return b"".join(np.asarray(each).tobytes() for each in (seen, *(self.env.step(a)[0] for a in self.actions)))

    def call(self, name: str, arguments: tuple[Any, ...]) -> str:
        """Call it, and let it play. Raises AssertionError for any harm."""
        try:
            if name == "reset":
                self.env.reset(seed=arguments[0], options=arguments[1])
            else:
                getattr(self.env, name)(*arguments)
            outcome = DONE
        except ERRORS as error:
            assert str(error), "an error without a word"
            outcome = REFUSED
        assert self.play() == self.played, "what is played afterwards is another match"
        return outcome


@cache
def target(name: str) -> Target:
    """Return an environment of this suite, made once."""
    return Target(MADE[name])


def spoiled(value: Any, rng: random.Random) -> Any:
    """Return something else in the place of an argument, or of a part of it."""
    kind = rng.random()
    if kind < 0.25 or not isinstance(value, np.ndarray | dict):
        return rng.choice([*STRANGE, *FEW, *NUMBERS.tolist()])
    if isinstance(value, dict):
        name = rng.choice([*value, "thetas"])
        if kind < 0.4:
            return {key: part for key, part in value.items() if key != name}
        return value | {name: spoiled(value.get(name), rng)}
    if kind < 0.45 and value.dtype.names is None:
        with np.errstate(all="ignore"):
            return value.astype(rng.choice(TYPES))
    if kind < 0.65:
        return rng.choice([value[:1], value[:0], value[None], value[..., None], np.repeat(value, 2, 0), value.tolist()])
    changed = copy.deepcopy(value)
    name = rng.choice(value.dtype.names) if value.dtype.names else None
    part = changed if name is None else changed[name]
    flat = part.reshape(-1)
    if flat.size and flat.dtype.kind in "fiub":
        with np.errstate(all="ignore"):
            numbers = NUMBERS if flat.dtype.kind == "f" else WORDS
            flat[rng.randrange(flat.size)] = numbers.astype(flat.dtype)[rng.randrange(len(numbers))]
    return changed


def attack(count: int, seed: int) -> dict[str, int]:
    """Make so many calls; return what became of them. Raises AssertionError for any harm."""
    counts = dict.fromkeys((DONE, REFUSED), 0)
    for index in range(count):
        rng = random.Random(f"{seed} {index}")
        name = rng.choice(list(MADE))
        called = target(name)
        method = rng.choice(list(called.good))
        arguments = list(called.good[method])
        place = rng.randrange(len(arguments))
        arguments[place] = spoiled(arguments[place], rng)
        what, began = f"call {index} of round {seed}: {name}.{method}({arguments!r:.300})", time.process_time()
        try:
            counts[called.call(method, tuple(arguments))] += 1
        except BaseException as fault:
            target.cache_clear()
            raise AssertionError(f"{what}: {type(fault).__name__}: {fault}") from fault
        spent = time.process_time() - began
        assert spent < SECONDS, f"{what}: took {spent:.1f} s"
    return counts


if __name__ == "__main__":
    for number in range(int(sys.argv[2]), int(sys.argv[3])):
        try:
            print(attack(int(sys.argv[1]), number))
        except AssertionError as harm:
            print(harm)
