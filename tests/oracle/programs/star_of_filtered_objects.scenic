#! id: star_of_filtered_objects
#! kind: static
#! n: 1200
class Stall:
    fruit: "none"
    bins: []
    allowCollisions: True
    requireVisible: False
stalls = [new Stall at 0 @ 0, with fruit "fig", with bins [3, 4],
          new Stall at 9 @ 0, with fruit "pear", with bins [5],
          new Stall at 18 @ 0, with fruit "fig", with bins [6, 7, 8, 11]]
chosen = Uniform(*filter(lambda s: s.fruit == "fig", stalls))
ego = new Object at 0 @ Uniform(*chosen.bins), with allowCollisions True
param where = chosen.position.x
