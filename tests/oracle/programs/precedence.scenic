#! id: precedence
#! kind: static
#! tags: precedence of operators
#! n: 20
ego = new Object at 2 * 3 @ 4, facing 10 deg + 20 deg
b = new Object at -7 @ 2 + 3 @ 1, facing 2 * 15 deg
param d = distance from ego to 3 @ 4
param e = (distance from ego to 0 @ 0) + 1
param f = (distance to 9 @ 9) > 3 and not False
param g = 2 ** 3 ** 2 - 7 / 2 * 3
