"""States and records of matches with a number changed: refused in a sentence, or played without harm to any other.

    python -m tests.envs.hostile COUNT SEED

Every second match of a batch gets a number that it should not have. Either the check of `set_state` refuses it, or the
batch is played some steps: then no match between them may come out differently, for kernels that write out of bounds
write into those first.
"""

from __future__ import annotations

import ast
import io
import sys
import time
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from regista.envs.football import replay as records
from regista.envs.football.config import FootballConfig
from regista.envs.football.constants import NO_FAULT
from regista.envs.football.limits import StateError, words_of
from regista.envs.football.replay import Recorder, RecordError, load_record, replay, save_record
from regista.envs.football.vector_env import FootballVectorEnv
from regista.minigames import MINIGAMES
from scenic_lite import ScenicError

PROGRAMS = ("3v2FourBehaviors", "1v1Free")
REPRESENTATIONS = ("features", "smm_stacked", "simple115")
NUM_ENVS, BEFORE, AFTER = 32, 30, 6  # matches, steps before the change, steps after it
SECONDS = 2.0  # of processor time, at most, for one batch
CHANGED = ("matches", "matches", "starts", "registers", "start_registers", "minimap_agents")
WORDS = np.array([-(2**63), 2**63 - 1, -2, -1, 0, 1, 5, 10, 19, 21, 22, 23, 400, 10**9, 2**31, 2**52], np.int64)
NUMBERS = np.array([np.nan, np.inf, -np.inf, -0.0, 1e308, -1e308, 1e-308, 1e9, -1e9, 3.5, 1e19, 55.0, 400.0])
TEXTS = ["", "{}", "[" * 500, "nan", "1e999", "null", '{"a": 1}', "\x00", "é" * 99]
MADE: dict[tuple[str, str], FootballVectorEnv] = {}  # of records
MOST_MADE = 100
REFUSED, PLAYED, FAULTED = "refused", "played", "stopped by a fault"


@cache
def environment(program: str, representation: str, count: int) -> FootballVectorEnv:
    """Return an environment, made once."""
    config = FootballConfig(representation=representation, control="all")
    return FootballVectorEnv(MINIGAMES[program].program, count, config=config)


class Target:
    """An environment with a state to begin from, and what becomes of it if nobody changes anything."""

    def __init__(self, program: str, representation: str, seed: int) -> None:
        self.env = environment(program, representation, NUM_ENVS)
        self.env.reset(seed=seed)
        self.actions = np.random.default_rng(seed).integers(0, 19, (BEFORE + AFTER, *self.env.action_space.shape))
        for action in self.actions[:BEFORE]:
            self.env.step(action)
        self.state = self.env.get_state()
        self.words = {name: words_of(self.state[name]) for name in CHANGED if self.state[name].size}
        self.expected, faulted = self._after(self.state)
        assert not faulted.any()

    def _after(self, state: dict[str, Any]) -> tuple[np.ndarray, np.ndarray]:
        """Return the matches after some steps, and which were stopped by a fault in one: those have begun anew."""
        self.env.set_state(state)
        faulted = np.zeros(NUM_ENVS, bool)
        for action in self.actions[BEFORE:]:
            try:
                self.env.step(action)
            except (FloatingPointError, ScenicError):  # found while it was played, and the program's line told
                faulted |= self.env._outcome.faults != NO_FAULT
        return self.env.matches, faulted

    def attempt(self, rng: np.random.Generator) -> dict[str, int]:
        """Change one number of every second match, and say what became of each. Raises AssertionError for any harm."""
        state, changes, refused = dict(self.state), [], 0
        words = {name: np.array(each) for name, each in self.words.items()}
        for row in range(1, NUM_ENVS, 2):
            name = str(rng.choice([name for name in CHANGED if name in words]))
            place = int(rng.integers(words[name].shape[1]))
            words[name][row, place] = value = hostile(rng, words[name][row, place])
            try:
                self.env._limits[name].check(words[name][row : row + 1], name)
                changes.append(f"word {place} of {name}[{row}] = {value}")
            except StateError:
                words[name][row, place] = self.words[name][row, place]
                refused += 1
        for name, each in words.items():
            state[name] = each.view(self.state[name].dtype).reshape(self.state[name].shape)
        began = time.process_time()
        after, faulted = self._after(state)
        what = "; ".join(changes)
        assert time.process_time() - began < SECONDS, f"one of these took too long: {what}"
        same = (after == self.expected) & ~faulted
        assert same[::2].all(), f"match {2 * np.argmin(same[::2])} was changed by one of: {what}"
        stopped = int(np.count_nonzero(faulted))
        return {REFUSED: refused, PLAYED: len(changes) - stopped, FAULTED: stopped}


def hostile(rng: np.random.Generator, before: np.int64) -> np.int64:
    """Return another 64 bits: a number from the edge of what there is, any bits, or the old ones with one turned."""
    kind = rng.integers(4)
    if kind == 0:
        return rng.choice(WORDS)
    if kind == 1:
        return rng.choice(NUMBERS).view(np.int64)
    if kind == 2:
        return rng.integers(-(2**63), 2**63 - 1, dtype=np.int64)
    return before ^ np.left_shift(np.int64(1), rng.integers(64))


def attack_states(count: int, seed: int) -> dict[str, int]:
    """Change so many states; return how many were refused, played, or stopped."""
    rng, counts = np.random.default_rng(seed), dict.fromkeys((REFUSED, PLAYED, FAULTED), 0)
    targets = [Target(program, kind, seed) for program in PROGRAMS for kind in REPRESENTATIONS]
    for k in range(count // (NUM_ENVS // 2)):
        for what, number in targets[k % len(targets)].attempt(rng).items():
            counts[what] += number
    return counts


@contextmanager
def known_programs() -> Iterator[None]:
    """Have records whose program and settings are as they were played in an environment that is made already.

    Headers of arrays are read once: their text is Python, whose parser would take most of the time.
    """
    make, evaluate = records.FootballVectorEnv, ast.literal_eval
    records.FootballVectorEnv = remembered  # type: ignore[assignment,misc]
    ast.literal_eval = lru_cache(1_000)(evaluate)  # type: ignore[assignment]
    try:
        yield
    finally:
        records.FootballVectorEnv, ast.literal_eval = make, evaluate  # type: ignore[misc]


def remembered(source: str | Path, num_envs: int, *, config: FootballConfig) -> FootballVectorEnv:
    """Return an environment of so many matches, of a program that is compiled already."""
    key = str(source), repr(config)  # what a record says need not be hashable
    if key not in MADE:
        if len(MADE) >= MOST_MADE:
            MADE.clear()
        MADE[key] = FootballVectorEnv(source, 1, config=config)
    return MADE[key].resized(num_envs)


def recorded(seed: int) -> bytes:
    """Return the file of a record."""
    rng = np.random.default_rng(seed)
    env = environment(PROGRAMS[seed % 2], REPRESENTATIONS[seed % 3], 2)
    lengths = np.array([AFTER, AFTER if seed % 4 else 1])
    env.idle[:] = False
    env.reset(seed=seed)
    recorder = Recorder(env)
    for step in range(AFTER):
        env.idle[:] = lengths <= step
        recorder.step(rng.integers(0, 19, env.action_space.shape))
    stored, record = io.BytesIO(), recorder.record()
    save_record(record if seed % 4 else replace(record, lengths=lengths), stored)
    return stored.getvalue()


def attack_records(count: int, seed: int, folder: Path) -> dict[str, int]:
    """Damage so many files of a record, byte by byte or entry by entry; return how many were refused or played."""
    rng, counts = np.random.default_rng(seed), dict.fromkeys((REFUSED, PLAYED, FAULTED), 0)
    stored, path = recorded(seed), folder / "record.npz"
    with zipfile.ZipFile(io.BytesIO(stored)) as archive:
        entries = {name: archive.read(name) for name in archive.namelist()}
    with known_programs():
        for _ in range(count):
            path.write_bytes(damaged(stored, rng) if rng.random() < 0.3 else altered(entries, rng))
            began = time.process_time()
            try:
                for _ in replay(load_record(path)):
                    pass
                counts[PLAYED] += 1
            except RecordError:
                counts[REFUSED] += 1
            except (FloatingPointError, ScenicError):
                counts[FAULTED] += 1
            assert time.process_time() - began < SECONDS, "a record took too long"
    return counts


def damaged(content: bytes, rng: np.random.Generator) -> bytes:
    """Return a file cut short, with bytes changed, or with a piece repeated or left out."""
    at, length = sorted(rng.integers(0, len(content), 2).tolist())
    kind = rng.integers(4)
    if kind == 0:
        return content[:at]
    if kind == 1:
        changed = bytearray(content)
        for place in rng.integers(0, len(content), 1 + rng.integers(8)):
            changed[place] = rng.integers(256)
        return bytes(changed)
    return content[:at] + content[length:] if kind == 2 else content[:length] + content[at:]


def altered(entries: dict[str, bytes], rng: np.random.Generator) -> bytes:
    """Return a whole archive of which one entry is another one: missing, of another type or shape, one word changed."""
    changed = str(rng.choice(list(entries)))
    array, kind = np.load(io.BytesIO(entries[changed])), rng.integers(6)
    other: np.ndarray | None = array
    if kind == 0:
        other = None
    elif kind == 1:
        other = array[:0] if array.ndim else np.array([array, array])
    elif kind == 2:
        other = np.array(rng.choice(TEXTS))
    elif kind == 3:
        other = np.array(rng.choice([np.nan, np.inf, -1.0, 1e300, 2.5]))
    elif array.dtype.kind in "Vif" and array.nbytes >= 8:
        words = np.frombuffer(bytearray(array.tobytes()), np.uint8)
        word = words[8 * int(rng.integers(len(words) // 8)) :][:8].view(np.int64)
        word[:] = hostile(rng, word[0])
        other = words.view(array.dtype).reshape(array.shape)
    file, content = io.BytesIO(), io.BytesIO()
    if other is not None:
        np.save(content, other)
    with zipfile.ZipFile(file, "w") as archive:
        for name, whole in entries.items():
            if name != changed or other is not None:
                archive.writestr(name, content.getvalue() if name == changed else whole)
    return file.getvalue()


if __name__ == "__main__":
    print(attack_states(int(sys.argv[1]), int(sys.argv[2])))
