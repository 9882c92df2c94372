"""Record the reference of the regression test of the football simulator, or compare this version with it.

The reference is `tests/envs/played.npz`: scenes and their outcomes. Without flags, the program plays the scenes and
prints the differences from the reference, row by row. Each row is also played eight times with a disturbance far larger
than the rounding of any processor, and three times with functions that round differently. A row is kept until the first
step at which any of these makes a difference.

    python -m lab.record_football                  # compare, write nothing
    python -m lab.record_football --write          # keep what is played now, under a new version
    python -m lab.record_football --write --amend  # keep it under the same version, before that is released
    python -m lab.record_football --draw --write   # from other scenes: see `lab/football_scenes.py`
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from lab.football_mutants import notice
from lab.football_scenes import draw_scenes
from regista.envs.football.version import SIMULATOR_VERSION
from tests.envs import played
from tests.envs.played import EVERY, FACTS, TOLERANCE, Kept, Scene

SEED = 1  # of the scenes
ROWS, LONG = 6, 30  # rows kept of a scene; minimum number of steady steps of a row, if such rows exist
WORTH = {"mode": 5, "left goals": 5, "right goals": 5, "ended": 5, "cards": 50, "agents": 0}  # weights; 1 for others
ROUNDINGS = (1, 2, 3)  # seeds of `lab/football_mutants.py`
COPIES = 4  # of each row with either disturbance:
AT_START, IN_EACH_STEP = 1e-7, 1e-12  # m of positions; m of positions and share of velocities, of moving things


def record(scene: Scene) -> Kept:
    """Play a scene, and find the number of steps for which each row does not depend on rounding."""
    rows, rng = len(scene.seeds), np.random.default_rng(0)

    def disturb(matches: np.ndarray, step: int) -> None:
        count, later = int(matches["num_players"][0]), rows * (1 + COPIES)
        for things in (matches["ball"][:, None], matches["players"][:, :count]):
            for axis in "xy":
                place, velocity = things[axis], things["v" + axis]
                if step == 0:
                    place[rows:later] += AT_START * rng.uniform(-1.0, 1.0, place[rows:later].shape)
                size = IN_EACH_STEP * (velocity[later:] != 0.0)  # standing players have exact positions
                place[later:] += size * rng.uniform(-1.0, 1.0, size.shape)
                velocity[later:] *= 1.0 + size * rng.uniform(-1.0, 1.0, size.shape)

    play = played.play(scene, 1 + 2 * COPIES, disturb)
    facts = play.facts.reshape(scene.steps, -1, rows, play.facts.shape[-1])  # [T, copies, R, F]
    digests = play.digests.reshape(len(play.digests), -1, rows, play.digests.shape[-1])
    same = (facts == facts[:, :1]).all((1, 3))  # [T, R]
    alike = (np.abs(digests - digests[:, :1]) <= TOLERANCE).all((1, 3))
    steady = np.logical_and.accumulate(same & np.repeat(alike, EVERY, 0)).sum(0) // EVERY * EVERY
    return Kept(scene, facts[:, 0], digests[:, 0], steady)


def choose(kept: Kept) -> Kept:
    """Return a scene with the rows that have most events while they are steady; rare events count more."""
    happens = (np.diff(kept.facts, axis=0) != 0) @ np.array([WORTH.get(name, 1) for name in FACTS])  # [T - 1, R]
    worth = [(until >= LONG, int(happens[: until - 1, row].sum())) for row, until in enumerate(kept.steady)]
    return of_rows(kept, sorted(range(len(worth)), key=lambda row: worth[row], reverse=True)[:ROWS])


def of_rows(kept: Kept, rows: Sequence[int]) -> Kept:
    """Return a scene with some of its rows, without rows that are never steady."""
    chosen = np.array([row for row in rows if kept.steady[row]], int)
    scene = replace(kept.scene, seeds=tuple(kept.scene.seeds[row] for row in chosen))
    return Kept(scene, kept.facts[:, chosen], kept.digests[:, chosen], kept.steady[chosen])


def cut(kept: Sequence[Kept], seed: int) -> list[Kept]:
    """Return scenes in the form of the file, each row cut at the first step that depends on rounding."""
    by_name = {one.scene.name: one for one in kept}
    for found in notice(["rounded", "--seed", str(seed)], only_first=False):
        steady = by_name[found["scene"]].steady
        steady[found["row"]] = min(steady[found["row"]], (found["step"] - 1) // EVERY * EVERY)
    return [one for one in (of_rows(each, range(len(each.steady))) for each in kept) if len(one.steady)]


def keep(scenes: Iterable[Scene], chosen: bool) -> None:
    """Play scenes and write the file; with `chosen`, only some of their rows are kept."""
    kept = [choose(record(scene)) if chosen else record(scene) for scene in scenes]
    kept = [one for one in kept if len(one.steady)]
    for seed in ROUNDINGS:
        played.save(SIMULATOR_VERSION, kept)
        kept = cut(kept, seed)
    played.save(SIMULATOR_VERSION, kept)
    steady = np.concatenate([one.steady for one in kept])
    print(f"{played.FILE}: {len(kept)} scenes, {len(steady)} rows of {steady.min()} to {steady.max()} steps")


def differences(old: Sequence[Kept]) -> list[str]:
    """Return the differences from the reference, a line for each row."""
    return [f"{one.scene.name}, {change}" for one in old for change in one.changes(played.play(one.scene))]


def main(argv: Sequence[str]) -> int:
    """Run the script and return its exit code: 1 if there are differences that are not kept."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    for flag in ("--write", "--amend", "--draw"):
        parser.add_argument(flag, action="store_true")
    typed = parser.parse_args(argv)
    version, old = played.load() if played.FILE.exists() else (SIMULATOR_VERSION, [])
    changed = differences(old)
    rows = sum(len(one.steady) for one in old)
    print(*changed, f"{len(changed)} of {rows} rows are played otherwise than in version {version}", sep="\n")
    if not typed.write:
        return int(bool(changed))
    if changed and version == SIMULATOR_VERSION and not typed.amend:
        print(f"nothing is written: raise SIMULATOR_VERSION, {version}, in envs/football/version.py, or give --amend")
        return 1
    keep(draw_scenes(SEED) if typed.draw or not old else [one.scene for one in old], typed.draw or not old)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
