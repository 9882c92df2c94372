#! id: requires_inside_functions
#! kind: static
#! n: 900
area = RectangularRegion(0 @ 0, 30 deg, 30, 30)
def place(room):
    spot = new Point in area
    box = RectangularRegion(spot.position, 0, room, room)
    require area.containsRegion(box)
    return spot
ego = new Object at place(8), with requireVisible False
other = new Object at place(4), with requireVisible False, with allowCollisions True
