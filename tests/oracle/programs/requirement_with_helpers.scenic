#! id: requirement_with_helpers
#! kind: static
#! tags: functions, chained comparisons, containers in requirements
#! n: 400
x = Range(0, 10)
k = DiscreteRange(0, 4)
ego = new Object at x @ k
def near(value, target):
    if abs(value - target) < 3:
        return True
    return False
require near(x, 5)
require 1 <= k < 4
require k in [1, 3]
