#! id: angles_and_measures
#! kind: static
#! n: 900
ego = new Object at 0 @ 0, facing 30 deg
b = new Object at Range(3, 6) @ Range(3, 6), facing toward ego
require 20 deg < abs(relative heading of b from ego)
param past = distance past b of ego
param turn = angle to b, rel = relative position of b
param far = distance from b to RectangularRegion(-5 @ 0, 0, 2, 2)
