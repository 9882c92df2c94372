#! id: area_grid
#! kind: static
#! tags: regions, grid
#! n: 600
from scenic.core.regions import GridRegion
g = GridRegion("g", [[0,1],[0,0]], 2, 3, 10, 20)
ego = new Object in g, with requireVisible False, with allowCollisions True
param a = g.containsPoint(10.4@20.4), b = g.containsPoint(12@20)
