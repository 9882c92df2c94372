"""Ctrl-C, SIGTERM and a closed terminal at any moment of any command: one line, 128 + the signal, nobody left."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
SIGNALS = (signal.SIGINT, signal.SIGINT, signal.SIGTERM, signal.SIGHUP)  # the first twice as often
FASTEST = 0.3  # s, in which Python itself starts: while it does, and when it ends, a signal ends it without a word
PATIENCE = 60.0  # s from the signal to the end, on a busy machine
TINY = ["--num-envs", "8", "--num-steps", "64", "--total-env-steps"]
COMMANDS: dict[str, list[str]] = {
    "train": ["train", "1v1Restricted", "--method", "plr", *TINY, "400_000", "--out", "{out}"],
    "compare": ["compare", "1v1Free", "--methods", "dr", "accel", "--seeds", "1", *TINY, "40_000", "--out", "{out}"],
    "frontier": ["compare", "ued.probes:frontier", "--seeds", "2", "--total-env-steps", "400_000", "--out", "{out}"],
    "evaluate": ["evaluate", "{run}", "--episodes", "200"],
    "demonstrate": ["demonstrate", "3v2FourBehaviors", "--episodes", "400", "--out", "{out}"],
    "play": ["play", "3v2FourBehaviors", "--steps", "3000", "--video", "{out}.gif"],
    "inspect": ["inspect", "3v2FourBehaviors", "--png", "{out}.png"],
    "list": ["list"],
    "benchmark": ["benchmark"],
    "replay": ["play", "--replay", "{record}", "--video", "{out}.gif"],
}

PREPARED = [  # what `evaluate` and `replay` need, in a folder `{run}`
    ["train", "1v1Restricted", "--method", "dr", *TINY, "2_000", "--no-record", "--out", "{run}"],
    ["play", "3v2FourBehaviors", "--record", "{run}/match.npz"],
]


def started(words: list[str], **settings: object) -> subprocess.Popen:
    """Start a command in a session of its own, as a terminal does."""
    before = [signal.signal(number, signal.SIG_DFL) for number in (signal.SIGINT, signal.SIGHUP)]
    try:
        return subprocess.Popen(
            [sys.executable, "-m", "regista", *words],
            cwd=ROOT,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            **settings,  # type: ignore[call-overload]
        )
    finally:
        for number, handler in zip((signal.SIGINT, signal.SIGHUP), before, strict=True):
            signal.signal(number, handler)


def children(tag: str) -> list[int]:
    """Return the processes that carry a tag in their environment: whatever a command has started, and itself."""
    pids = []
    for folder in Path("/proc").iterdir():
        if folder.name.isdecimal():
            try:
                if f"REGISTA_TORTURE={tag}".encode() in (folder / "environ").read_bytes().split(b"\0"):
                    pids.append(int(folder.name))
            except OSError:
                continue
    return pids


def interrupt(name: str, out: Path, run: Path, seconds: float, number: int) -> str:
    """Start a command, send it a signal after so many seconds, and say how it ended.

    Raises AssertionError unless that was well: the right code, no traceback, no process left.
    """
    words = [word.format(out=out, run=run, record=run / "match.npz") for word in COMMANDS[name]]
    tag = f"{os.getpid()}-{out.name}"
    process = started(words, env=os.environ | {"REGISTA_TORTURE": tag})
    time.sleep(seconds)
    done = process.poll() is not None
    if not done:
        os.killpg(process.pid, number)
    try:
        said = process.communicate(timeout=PATIENCE)[0].decode(errors="replace")
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        raise AssertionError(f"{name}: {signal.Signals(number).name} after {seconds:.2f} s was not heard") from None
    what = (
        f"{name}: {signal.Signals(number).name} after {seconds:.2f} s: exit code {process.returncode}: {said[-1500:]}"
    )
    late = time.monotonic() + 10.0
    while (left := children(tag)) and time.monotonic() < late:
        time.sleep(0.1)
    for each in left:
        os.kill(each, signal.SIGKILL)
    assert not left, f"{what}; {len(left)} processes were left"
    assert "Traceback" not in said and "Exception ignored" not in said, what
    assert process.returncode in (0, 128 + number, -number), what
    return {0: "too late", -number: "outside of us"}.get(process.returncode, "ended")


def attack(count: int, seed: int, folder: Path) -> dict[str, int]:
    """Interrupt commands at so many random moments; return how many were ended and how many had finished before."""
    rng, counts = random.Random(seed), {"ended": 0, "outside of us": 0, "too late": 0}
    run = folder / "run"
    if not (run / "match.npz").exists():
        for words in PREPARED:
            process = started([word.format(run=run) for word in words])
            said = process.communicate()[0].decode()
            assert process.returncode == 0, said
    for k in range(count):
        name = list(COMMANDS)[k % len(COMMANDS)]
        seconds = FASTEST + float(np.exp(rng.uniform(np.log(0.02), np.log(15.0))))
        counts[interrupt(name, folder / f"{seed}-{k}", run, seconds, rng.choice(SIGNALS))] += 1
    return counts


if __name__ == "__main__":
    print(attack(int(sys.argv[1]), int(sys.argv[2]), Path(sys.argv[3])))
