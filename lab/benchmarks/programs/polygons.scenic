"""Two cars and a bicycle on an L-shaped street, each wholly inside it; a pedestrian on the pavement."""

street = PolygonalRegion([(0, 0), (60, 0), (60, 12), (12, 12), (12, 60), (0, 60)])
pavement = PolygonalRegion([(12, 12), (60, 12), (60, 16), (16, 16), (16, 60), (12, 60)])

class Car:
    width: 2
    length: 4.5
    requireVisible: False
    regionContainedIn: street

ego = new Car in street, facing Range(-180, 180) deg
other = new Car in street, facing Range(-180, 180) deg
bicycle = new Car in street, with width 0.6, with length 1.8, facing Range(0, 360) deg
new Object in pavement, with width 0.5, with length 0.5, with requireVisible False
