#! id: mutation_all
#! kind: static
#! tags: mutate without names, noise by class
#! n: 500
class Loose:
    positionStdDev: 3
    headingStdDev: 10 deg
ego = new Object at 0 @ 0, with requireVisible False, with allowCollisions True
b = new Loose at 30 @ 0, facing 20 deg, with requireVisible False, with allowCollisions True
mutate
c = new Object at 60 @ 0, with requireVisible False, with allowCollisions True
