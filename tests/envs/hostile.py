"""States and records of matches with a number changed: refused in a sentence, or played without harm to any other.

    python -m tests.envs.hostile COUNT SEED

One match of a batch gets a number that it should not have. Either `set_state` refuses it, or the batch is played some
steps: then no other match may come out differently, for kernels that write out of bounds write into those first.
"""

from __future__ import annotations

import io
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from envs.football.config import FootballConfig
from envs.football.limits import StateError
from envs.football.replay import Recorder, RecordError, load_record, replay, save_record
from envs.football.vector_env import FootballVectorEnv
from minigames import MINIGAMES
from scenic_lite import ScenicError

PROGRAMS = ("3v2FourBehaviors", "1v1Free")
REPRESENTATIONS = ("features", "smm_stacked", "simple115")
NUM_ENVS, BEFORE, AFTER = 4, 30, 6  # matches, steps before the change, steps after it
SECONDS = 2.0  # of processor time, at most, for one state
WORDS = np.array([-(2**63), 2**63 - 1, -2, -1, 0, 1, 5, 10, 19, 21, 22, 23, 400, 10**9, 2**31, 2**52], np.int64)
NUMBERS = np.array([np.nan, np.inf, -np.inf, -0.0, 1e308, -1e308, 1e-308, 1e9, -1e9, 3.5, 1e19, 55.0, 400.0])
TEXTS = ["", "{}", "[" * 500, "nan", "1e999", "null", '{"a": 1}', "\x00", "é" * 99]
REFUSED, PLAYED, FAULTED = "refused", "played", "stopped by a fault"


class Target:
    """An environment with a state to begin from, and what becomes of it if nobody changes anything."""

    def __init__(self, program: str, representation: str, seed: int) -> None:
        config = FootballConfig(representation=representation, control="all")
        self.env = FootballVectorEnv(MINIGAMES[program].program, NUM_ENVS, config=config)
        self.env.reset(seed=seed)
        self.actions = np.random.default_rng(seed).integers(0, 19, (BEFORE + AFTER, *self.env.action_space.shape))
        for action in self.actions[:BEFORE]:
            self.env.step(action)
        self.state = self.env.get_state()
        self.expected = self._after(self.state)

    def _after(self, state: dict[str, Any]) -> np.ndarray:
        self.env.set_state(state)
        for action in self.actions[BEFORE:]:
            self.env.step(action)
        return self.env.matches

    def attempt(self, rng: np.random.Generator) -> str:
        """Change one number of one match, and say what became of it. Raises AssertionError for any harm."""
        state, row = dict(self.state), int(rng.integers(NUM_ENVS))
        name = str(rng.choice(["matches", "matches", "starts", "registers", "start_registers", "minimap_agents"]))
        array = np.array(state[name])
        if not array.size:
            return self.attempt(rng)
        words = array.reshape(-1).view(np.int64).reshape(NUM_ENVS, -1)
        place = int(rng.integers(words.shape[1]))
        value = hostile(rng, words[row, place])
        words[row, place] = value
        state[name] = array
        what, began = f"word {place} of {name}[{row}] = {value}", time.process_time()
        try:
            after = self._after(state)
        except StateError:
            return REFUSED
        except (FloatingPointError, ScenicError):
            return FAULTED  # found while it was played: the match was put back, and the program's line told
        finally:
            assert time.process_time() - began < SECONDS, f"{what} took too long"
        others = np.arange(NUM_ENVS) != row
        assert (after[others] == self.expected[others]).all(), f"{what} changed another match"
        return PLAYED


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
    for k in range(count):
        counts[targets[k % len(targets)].attempt(rng)] += 1
    return counts


def attack_records(count: int, seed: int, folder: Path) -> dict[str, int]:
    """Damage so many files of a record, byte by byte or entry by entry; return how many were refused or played."""
    rng, counts = np.random.default_rng(seed), dict.fromkeys((REFUSED, PLAYED, FAULTED), 0)
    env = FootballVectorEnv(MINIGAMES[PROGRAMS[1]].program, 2)
    env.reset(seed=seed)
    recorder = Recorder(env)
    for action in rng.integers(0, 19, (AFTER, 2)):
        recorder.step(action)
    stored = io.BytesIO()
    save_record(recorder.record(), stored)
    with np.load(io.BytesIO(stored.getvalue())) as archive:
        entries = {name: archive[name] for name in archive.files}
    path = folder / "record.npz"
    for _ in range(count):
        path.write_bytes(damaged(stored.getvalue(), rng) if rng.random() < 0.3 else altered(entries, rng))
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


def altered(entries: dict[str, np.ndarray], rng: np.random.Generator) -> bytes:
    """Return a whole archive of which one entry is another one: missing, of another type or shape, one word changed."""
    entries, name = dict(entries), str(rng.choice(list(entries)))
    array, kind = entries[name], rng.integers(6)
    if kind == 0:
        del entries[name]
    elif kind == 1:
        entries[name] = array[:0] if array.ndim else np.array([array, array])
    elif kind == 2:
        entries[name] = np.array(rng.choice(TEXTS))
    elif kind == 3:
        entries[name] = np.array(rng.choice([np.nan, np.inf, -1.0, 1e300, 2.5]))
    elif array.dtype.kind in "Vif" and array.nbytes >= 8:
        content = np.frombuffer(bytearray(array.tobytes()), np.uint8)
        place = 8 * int(rng.integers(len(content) // 8))
        content[place : place + 8].view(np.int64)[:] = hostile(rng, content[place : place + 8].view(np.int64)[0])
        entries[name] = content.view(array.dtype).reshape(array.shape)
    file = io.BytesIO()
    np.savez(file, **entries)
    return file.getvalue()


if __name__ == "__main__":
    print(attack_states(int(sys.argv[1]), int(sys.argv[2])))
