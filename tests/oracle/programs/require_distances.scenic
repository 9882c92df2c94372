#! id: require_distances
#! kind: static
#! tags: compound requirements with operators
#! n: 400
ego = new Object at Range(-10, 10) @ Range(-10, 10)
b = new Object at Range(-10, 10) @ Range(-10, 10)
require 5 < (distance to b) < 9
require (relative heading of b) == 0 and abs(angle to b) > 90 deg
