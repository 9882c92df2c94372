"""Requirements that hold in a share of the scenes only, and values of every distribution."""

class Body:
    requireVisible: False

ego = new Body at Normal(0, 4) @ TruncatedNormal(0, 4, -6, 6), facing Uniform(0, 90, 180) deg
other = new Body at Range(-20, 20) @ DiscreteRange(-20, 20), with speed Discrete({1: 3, 2: 2, 5: 1})
third = new Body offset by Range(-9, 9) @ Range(2, 9)

require[0.8] (distance from ego to other) > 10
require[0.5] (angle from ego to other) > 0
require[0.9] (distance from other to third) < 20
