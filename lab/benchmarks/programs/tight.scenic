"""Three that must stand close, in order, and far from a fourth: one draw in thirty is a scene."""

field = RectangularRegion(0 @ 0, 0, 60, 40)
workspace = Workspace(field)

class Body:
    requireVisible: False

ego = new Body in field
second = new Body in field
third = new Body in field
keeper = new Body in field

require (distance from ego to second) < 25
require (distance from second to third) < 25
require ego.position.x < second.position.x
require second.position.x < third.position.x
require (distance from keeper to third) > 20
