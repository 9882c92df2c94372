"""What tells two records of a dynamic program apart: traces, lengths, endings, records; their frequencies if they vary.

A program that is simulated once must do the same, action by action; one that is simulated often must reject as often,
and take each joint action at each step as often, within five standard errors. Read next: `compare`.
"""

import json
import math
from collections.abc import Iterator


def of_episodes(expected: dict, found: dict) -> Iterator[str]:
    """Return where a record of ours is unlike real Scenic's."""
    sizes = expected["sims"], found["sims"]
    yield from of_frequencies("simulations", {"rejected": expected["rejected"]}, {"rejected": found["rejected"]}, sizes)
    if expected["sims"] == 1:
        yield from of_one(expected, found)
        return
    played = max(1, sizes[0] - expected["rejected"]), max(1, sizes[1] - found["rejected"])
    yield from of_frequencies("the length", expected["lengths"], found["lengths"], played)
    for step, actions in expected.get("per_step", {}).items():
        yield from of_frequencies(f"step {step}", actions, found.get("per_step", {}).get(step, {}), played)
    yield from of_frequencies("the trace", traces(expected), traces(found), played)


def of_one(expected: dict, found: dict) -> Iterator[str]:
    """Yield the differences of two programs that do the same every time."""
    for key in ("traces", "lengths", "records"):
        if expected.get(key) != found.get(key):
            yield f"{key}: {json.dumps(expected.get(key))} expected, {json.dumps(found.get(key))} found"
    kinds = [[ending.split(":")[0] for ending in each["endings"]] for each in (expected, found)]
    if kinds[0] != kinds[1]:
        yield f"the ending: {expected['endings']} expected, {found['endings']} found"


def traces(record: dict) -> dict[str, int]:
    return {json.dumps(each["trace"]): each["count"] for each in record["traces"]}


def of_frequencies(what: str, expected: dict, found: dict, sizes: tuple[int, int]) -> Iterator[str]:
    n, m = sizes
    for key in sorted({*expected, *found}):
        share, ours = expected.get(key, 0) / n, found.get(key, 0) / m
        pooled = (n * share + m * ours) / (n + m)
        variance = max(pooled * (1 - pooled), 1 / (n + m)) * (1 / n + 1 / m)
        if abs(share - ours) > 5 * math.sqrt(variance):
            yield f"{what}: {key} {share:.3f} expected, {ours:.3f} found"
