"""Every distribution and value derived from one against exact moments and the exact cumulative distribution.

Seeds are fixed, and every test is sharp: the same values moved by 0.15 standard deviations must fail it. `spread` times
1.15 must fail the variance. Read next: `test_distributions`.
"""

import math
from statistics import NormalDist

import numpy as np
import pytest
from scene import things

N = 20_000
SHIFT = 0.15  # standard deviations
KOLMOGOROV = 1.95 / math.sqrt(N)  # exceeded once in a thousand
SIGMAS = 4.5  # of an estimated mean, or of an estimated variance

STANDARD = NormalDist()


def uniform(low, high):
    return lambda x: np.clip((x - low) / (high - low), 0, 1)


def normal(mean, spread):
    return np.vectorize(NormalDist(mean, spread).cdf)


def truncated(mean, spread, low, high):
    below, above = ((end - mean) / spread for end in (low, high))
    share = STANDARD.cdf(above) - STANDARD.cdf(below)
    cdf = np.vectorize(lambda x: (STANDARD.cdf((min(max(x, low), high) - mean) / spread) - STANDARD.cdf(below)) / share)
    a, b = STANDARD.pdf(below), STANDARD.pdf(above)
    middle = (a - b) / share
    return mean + spread * middle, spread**2 * (1 + (below * a - above * b) / share - middle**2), cdf


def triangle(x):
    """Return the distribution function of the sum of two uniform values on [0, 1]."""
    return np.where(x < 1, x**2 / 2, 1 - (2 - x) ** 2 / 2)


# text -> mean, variance, cumulative distribution
CONTINUOUS = {
    "Range(2, 7)": (4.5, 25 / 12, uniform(2, 7)),
    "Range(-15, -25)": (-20, 100 / 12, uniform(-25, -15)),
    "Normal(3, 2)": (3, 4, normal(3, 2)),
    "TruncatedNormal(0, 1, -0.5, 2)": truncated(0, 1, -0.5, 2),
    "TruncatedNormal(5, 3, 6, 7)": truncated(5, 3, 6, 7),
    "Range(0, 1) + Range(0, 1)": (1, 1 / 6, triangle),
    "Range(0, 1) * Range(0, 1)": (1 / 4, 7 / 144, lambda x: x - x * np.log(x)),
    "Range(0, Range(0, 1))": (1 / 4, 7 / 144, lambda x: x - x * np.log(x)),
    "2 * Range(0, 1) - 3": (-2, 1 / 3, uniform(-3, -1)),
    "Range(0, 1) ** 2": (1 / 3, 4 / 45, np.sqrt),
    "abs(Normal(0, 1))": (math.sqrt(2 / math.pi), 1 - 2 / math.pi, lambda x: 2 * normal(0, 1)(x) - 1),
    "max(Range(0, 1), Range(0, 1))": (2 / 3, 1 / 18, lambda x: x**2),
    "min(Range(0, 1), Range(0, 1))": (1 / 3, 1 / 18, lambda x: 1 - (1 - x) ** 2),
    "Normal(Range(-1, 1), 1)": (0, 1 + 1 / 3, None),
    "Uniform(Range(0, 1), Range(2, 3))": (1.5, 1 + 1 / 12, lambda x: (uniform(0, 1)(x) + uniform(2, 3)(x)) / 2),
    "sin(Range(0, 90) deg)": (2 / math.pi, 0.5 - 4 / math.pi**2, lambda x: np.arcsin(x) / (math.pi / 2)),
    "hypot(Normal(0, 1), Normal(0, 1))": (math.sqrt(math.pi / 2), 2 - math.pi / 2, lambda x: 1 - np.exp(-(x**2) / 2)),
    "1 / Range(1, 2)": (math.log(2), 0.5 - math.log(2) ** 2, lambda x: 2 - 1 / x),
}
# text -> probabilities by value
DISCRETE = {
    "Uniform(1, 5, 9)": {1: 1 / 3, 5: 1 / 3, 9: 1 / 3},
    "Discrete({10: 1, 20: 3, 30: 6})": {10: 0.1, 20: 0.3, 30: 0.6},
    "DiscreteRange(1, 6)": dict.fromkeys(range(1, 7), 1 / 6),
    "DiscreteRange(0, 1) + DiscreteRange(0, 1)": {0: 0.25, 1: 0.5, 2: 0.25},
    "int(Range(0, 3))": dict.fromkeys(range(3), 1 / 3),
    "round(Range(0, 2))": {0: 0.25, 1: 0.5, 2: 0.25},
    "Uniform(*range(4)) % 2": {0: 0.5, 1: 0.5},
}


def values(text, seed=1):
    program = things(f"param value = {text}")
    theta = np.random.default_rng(seed).uniform(-1, 1, (N, program.dim))
    return np.asarray(program.instantiate(theta).params["value"], dtype=float)


def moments_agree(found, mean, variance):
    """Return whether mean and variance lie within what chance allows; the variance's own error is estimated."""
    fourth = np.mean((found - found.mean()) ** 4)
    error = math.sqrt(max(fourth - found.var() ** 2, 1e-12) / N)
    near_mean = abs(found.mean() - mean) < SIGMAS * math.sqrt(variance / N)
    return near_mean and abs(found.var() - variance) < SIGMAS * error


def distribution_agrees(found, cdf):
    ordered = np.sort(found)
    with np.errstate(all="ignore"):
        distance = np.abs(cdf(ordered) - (np.arange(N) + 0.5) / N)
    return np.nanmax(np.where(np.isnan(distance), np.inf, distance)) < KOLMOGOROV


@pytest.mark.parametrize("text", CONTINUOUS)
def test_continuous_values(text):
    mean, variance, cdf = CONTINUOUS[text]
    found = values(text)
    assert moments_agree(found, mean, variance)
    shift = SHIFT * math.sqrt(variance)
    assert not moments_agree(found + shift, mean, variance)
    assert not moments_agree(mean + 1.15 * (found - mean), mean, variance)
    if cdf is not None:
        assert distribution_agrees(found, cdf)
        assert not distribution_agrees(found + shift, cdf)


@pytest.mark.parametrize("text", DISCRETE)
def test_discrete_values(text):
    shares = DISCRETE[text]
    found = values(text)
    assert set(found) == set(shares)
    mean = sum(value * share for value, share in shares.items())
    variance = sum((value - mean) ** 2 * share for value, share in shares.items())
    assert abs(found.mean() - mean) < SIGMAS * math.sqrt(variance / N)
    assert abs(found.mean() + SHIFT * math.sqrt(variance) - mean) > SIGMAS * math.sqrt(variance / N)
    chi_squared = sum((np.sum(found == v) - N * p) ** 2 / (N * p) for v, p in shares.items())
    freedom = len(shares) - 1
    assert chi_squared < freedom + 4 * math.sqrt(2 * freedom) + 4


# ------------------------------------------------------------ points of regions

SECTOR_ANGLE = 1.5
POINTS = {  # region -> mean x, mean y, variance of x, variance of y
    "RectangularRegion(1 @ 2, 0, 6, 4)": (1, 2, 3, 4 / 3),
    "RectangularRegion(1 @ 2, 90 deg, 6, 4)": (1, 2, 4 / 3, 3),
    "CircularRegion(1 @ 2, 4)": (1, 2, 4, 4),
    "SectorRegion(0 @ 0, 3, 0, 180 deg)": (0, 4 / math.pi, 9 / 4, 9 / 4 - 16 / math.pi**2),
    "PolygonalRegion([(0, 0), (6, 0), (0, 3)])": (2, 1, 2, 0.5),
    "PolygonalRegion([(0, 0), (4, 0), (4, 2), (2, 2), (2, 4), (0, 4)])": (5 / 3, 5 / 3, 11 / 9, 11 / 9),
    "PolylineRegion([(0, 0), (6, 0), (6, 2)])": (3.75, 0.25, 63 / 16, 13 / 48),
    "PointSetRegion('spots', [(0, 0), (3, 0), (3, 6)])": (2, 2, 2, 8),
}


@pytest.mark.parametrize("region", POINTS)
def test_points_of_regions(region):
    mean_x, mean_y, variance_x, variance_y = POINTS[region]
    program = things(f"a = new Thing in {region}")
    theta = np.random.default_rng(2).uniform(-1, 1, (N, program.dim))
    places = program.instantiate(theta).positions[:, 1]
    for axis, (mean, variance) in enumerate(((mean_x, variance_x), (mean_y, variance_y))):
        assert moments_agree(places[:, axis], mean, variance)
        assert not moments_agree(places[:, axis] + SHIFT * math.sqrt(variance), mean, variance)


def test_the_radius_and_the_bearing_in_a_sector():
    program = things(f"a = new Thing in SectorRegion(0 @ 0, 3, 0.3, {SECTOR_ANGLE})")
    theta = np.random.default_rng(3).uniform(-1, 1, (N, program.dim))
    x, y = program.instantiate(theta).positions[:, 1].T
    bearing = np.arctan2(y, x) - math.pi / 2 - 0.3
    assert distribution_agrees(np.hypot(x, y), lambda r: r**2 / 9)
    assert distribution_agrees(bearing, uniform(-SECTOR_ANGLE / 2, SECTOR_ANGLE / 2))
    assert not distribution_agrees(bearing + SHIFT * bearing.std(), uniform(-SECTOR_ANGLE / 2, SECTOR_ANGLE / 2))


# ------------------------------------------------------------ what belongs together

CORRELATIONS = {  # program -> correlation of the parameters p and q
    "x = Range(0, 1)\nparam p = x, q = x": 1,
    "x = Range(0, 1)\nparam p = x, q = 1 - x": -1,
    "x = Range(0, 1)\nparam p = x, q = x + Range(0, 1)": math.sqrt(0.5),
    "param p = Range(0, 1), q = Range(0, 1)": 0,
    "x = Normal(0, 1)\nparam p = 3 * x + Normal(0, 4), q = x": 0.6,
    "x = Range(0, 1)\nparam p = x, q = resample(x)": 0,
    "a = new Thing at Range(0, 1) @ 0\nparam p = a.position.x, q = a.position.x + Range(0, 1)": math.sqrt(0.5),
    "c = Uniform(0, 1)\nparam p = c, q = Uniform(c, 1 - c)": 0,
    "def f():\n    return Range(0, 1)\nparam p = f(), q = f()": 0,
    "x = [Range(0, 1) for i in range(2)]\nparam p = x[0], q = x[0] + x[1]": math.sqrt(0.5),
}


@pytest.mark.parametrize("text", CORRELATIONS)
def test_shared_draws_correlate_and_separate_ones_do_not(text):
    program = things(text)
    theta = np.random.default_rng(4).uniform(-1, 1, (N, program.dim))
    params = program.instantiate(theta).params
    found = np.corrcoef(params["p"], params["q"])[0, 1]
    wanted = CORRELATIONS[text]
    assert abs(found - wanted) < SIGMAS * max(1 - wanted**2, 1e-9) / math.sqrt(N)


# ------------------------------------------------------------ what rejection leaves


def test_rejection_leaves_the_conditional_distribution():
    program = things("x = Range(0, 2)\ny = Range(0, 2)\nparam value = x\nrequire x + y < 2")
    _, scenes = program.sample(N, np.random.default_rng(5))
    assert distribution_agrees(scenes.params["value"], lambda x: x - x**2 / 4)
    assert not distribution_agrees(scenes.params["value"] + SHIFT * math.sqrt(2 / 9), lambda x: x - x**2 / 4)


def test_a_soft_requirement_holds_in_its_share_and_by_chance_beyond():
    program = things("x = Range(0, 1)\nparam value = x\nrequire[0.6] x < 0.25")
    _, scenes = program.sample(N, np.random.default_rng(6))
    share = np.mean(scenes.params["value"] < 0.25)
    wanted = 0.6 + 0.4 * 0.25
    assert abs(share - wanted) < SIGMAS * math.sqrt(wanted * (1 - wanted) / N)


def test_noise_has_its_own_spread():
    program = things("a = new Thing at Range(0, 1) @ 7, facing 1\nmutate a by 2")
    theta = np.random.default_rng(7).uniform(-1, 1, (N, program.dim))
    scenes = program.instantiate(theta)
    assert moments_agree(scenes.positions[:, 1, 0], 0.5, 1 / 12 + 4)
    assert moments_agree(scenes.positions[:, 1, 1], 7, 4)
    assert distribution_agrees(scenes.headings[:, 1], normal(1, math.radians(10)))
