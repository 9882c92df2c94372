"""Sixty people on a square, none in another's way: 1,770 pairs are tested in every scene."""

square = RectangularRegion(0 @ 0, 0, 200, 200)
workspace = Workspace(square)

class Person:
    width: 0.6
    length: 0.4
    requireVisible: False

ego = new Person in square, facing Range(0, 360) deg
for i in range(59):
    new Person in square, facing Range(0, 360) deg
