#! id: stars_in_calls
#! kind: static
#! n: 600
def mean(a, b, *more):
    return (a + b) / 2
pair = Uniform((2, 6), (10, 20))
ego = new Object at max(*pair) @ min(*pair, 4)
param middle = mean(*pair)
