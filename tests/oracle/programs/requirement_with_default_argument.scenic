#! id: requirement_with_default_argument
#! kind: static
#! tags: functions in requirements, precedence of and, or
#! n: 400
ego = new Object at 0 @ 0
a = new Object at Range(1, 10) @ 3
def near(o, limit=5):
    """is it near"""
    d = distance from ego to o
    return d < limit
require near(a) or near(a, limit=8) and a.x > 6
