"""Eight in two rows, each a little out of its place."""

workspace = Workspace(RectangularRegion(0 @ 0, 0, 40, 20))

class Body:
    requireVisible: False

ego = new Body at -12 @ -4
for x in [-4, 4, 12]:
    new Body at x @ -4
for x in [-12, -4, 4, 12]:
    new Body at x @ 4, facing 180 deg

mutate
