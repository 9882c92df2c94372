"""Two teams of eleven in their formation, and a ball: 23 objects, 46 draws."""

pitch = RectangularRegion(0 @ 0, 0, 210, 94)
workspace = Workspace(pitch)

class Player:
    width: 0.8
    length: 0.8
    requireVisible: False

formation = [(-95, 0), (-65, -25), (-70, -9), (-70, 9), (-65, 25), (-40, -15), (-45, 0), (-40, 15),
             (-15, -20), (-10, 0), (-15, 20)]

def area(x, y):
    return RectangularRegion(x @ y, 0, 14, 14)

for x, y in formation:
    new Player in area(x, y), facing -90 deg
for x, y in formation:
    new Player in area(-x, y), facing 90 deg

ego = new Player at Range(-5, 5) @ Range(-5, 5), with width 0.3, with length 0.3
