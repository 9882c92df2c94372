"""What tells two records of a program apart: sentences, none if they agree within sampling error.

The limits let one comparison in some thousands fail by chance. Constants agree within 1e-6; means within five standard
errors, spreads within 15 %, distributions by the greatest distance of their quantile curves, frequencies within five
standard errors; errors in their line. Read next: `tests/scenic_lite/test_oracle.py`, which uses it.
"""

import bisect
import math

from tests.oracle.compare_dynamic import of_episodes, of_frequencies

CURVE = 1 / 40  # by which 41 quantiles may misstate a distribution


def differences(expected: dict, found: dict) -> list[str]:
    """Return where a record of ours is unlike real Scenic's."""
    if "error" in expected or "error" in found:
        return list(of_errors(expected.get("error"), found.get("error")))
    if expected["kind"] == "dynamic":
        return list(of_episodes(expected, found))
    if "values" not in expected:
        return []
    sizes = expected["n"], found["n"]
    said = []
    for name, value in expected["values"].items():
        if name in found["values"]:
            said += of_values(name, value, found["values"][name], sizes)
        else:
            said.append(f"{name} is missing")
    for name, value in expected.get("rel", {}).items():
        said += of_values(name, value, found["rel"][name], sizes)
    said += of_correlations(expected.get("corr"), found.get("corr"), min(sizes))
    return said


def of_errors(expected: dict | None, found: dict | None):
    if expected is None:
        assert found is not None
        yield f"real Scenic accepts it; here {found['message']}"
    elif found is None:
        yield f"real Scenic: {expected['type']}: {expected['message']}; here no error"
    elif expected.get("line") not in (None, 1, found.get("line")):  # 1 stands for a place that Scenic did not know
        yield f"real Scenic: line {expected['line']}: {expected['message']}; line {found.get('line')} here"


def of_values(name: str, expected: dict, found: dict, sizes: tuple[int, int]):
    """Yield the differences of two descriptions, of as many scenes as `sizes` says."""
    if "const" in expected and "const" in found:
        yield from of_constants(name, expected["const"], found["const"])
    elif ("const" in expected) != ("const" in found):
        if max(expected.get("sd", 1), found.get("sd", 1)) > 1e-6:
            yield f"{name}: {expected.get('const', 'varies')} expected, {found.get('const', 'varies')} found"
    elif "counts" in expected and "counts" in found:
        yield from of_frequencies(name, expected["counts"], found["counts"], sizes)
    elif "mean" in expected and "mean" in found:
        yield from of_numbers(name, expected, found, sizes)
    else:
        yield f"{name}: numbers on one side only"


def of_constants(name: str, expected: object, found: object):
    if isinstance(expected, float | int) and isinstance(found, float | int) and not isinstance(expected, bool):
        gap = abs(expected - found)
        if name.endswith("heading"):
            gap = min(gap, abs(math.tau - gap))
        if not gap > 1e-6 * max(1, abs(expected)):
            return
    if expected != found:
        yield f"{name}: {expected!r} expected, {found!r} found"


def of_numbers(name: str, expected: dict, found: dict, sizes: tuple[int, int]):
    n, m = sizes
    error = math.hypot(expected["sd"] / math.sqrt(n), found["sd"] / math.sqrt(m))
    resultant = expected.get("resultant", 1)
    if resultant < 0.999 and "resultant" in found:
        turn = math.remainder(expected["circular_mean"] - found["circular_mean"], math.tau)
        if resultant > 0.15 and abs(turn) > 6 * error / resultant + 1e-6:
            yield f"{name}: circular mean {expected['circular_mean']} expected, {found['circular_mean']} found"
        if abs(resultant - found["resultant"]) > 5 / math.sqrt(min(n, m)):
            yield f"{name}: resultant {resultant} expected, {found['resultant']} found"
        if expected["max"] > math.pi - 0.1 and expected["min"] < 0.1 - math.pi:
            return  # goes all round, so that the quantiles say nothing
    elif abs(expected["mean"] - found["mean"]) > 5 * error + 1e-9:
        yield f"{name}: mean {expected['mean']} expected, {found['mean']} found"
    if abs(expected["sd"] - found["sd"]) > expected["sd"] * (0.15 + 5 / math.sqrt(2 * min(n, m))):
        yield f"{name}: standard deviation {expected['sd']} expected, {found['sd']} found"
    if "quantiles" in expected and "quantiles" in found:
        gap = distance(expected["quantiles"], found["quantiles"])
        if gap > 2.2 * math.sqrt((n + m) / (n * m)) + CURVE:
            yield f"{name}: the distributions differ by {gap:.3f}"


def distance(first: list[float], second: list[float]) -> float:
    """Return the greatest gap between two distribution functions that are given by their quantiles."""
    return max(abs(below(first, x) - below(second, x)) for x in [*first, *second])


def below(quantiles: list[float], x: float) -> float:
    """Return the share of a distribution below x."""
    if x < quantiles[0]:
        return 0.0
    if x >= quantiles[-1]:
        return 1.0
    i = bisect.bisect_right(quantiles, x) - 1
    return (i + (x - quantiles[i]) / (quantiles[i + 1] - quantiles[i])) / (len(quantiles) - 1)


def of_correlations(expected: dict | None, found: dict | None, size: int):
    if expected is None or found is None:
        return
    at = {name: i for i, name in enumerate(found["names"])}
    for i, a in enumerate(expected["names"]):
        for j, b in enumerate(expected["names"][:i]):
            if a in at and b in at:
                want, have = expected["matrix"][i][j], found["matrix"][at[a]][at[b]]
                if abs(want - have) > 6 / math.sqrt(size):
                    yield f"the correlation of {a} and {b}: {want} expected, {have} found"
