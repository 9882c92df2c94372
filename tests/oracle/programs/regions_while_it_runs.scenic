#! id: regions_while_it_runs; kind: dynamic
#! tags: region:containsPoint
#! steps: 4; sims: 1; drift: 1; timestep: 1
reg = RectangularRegion(0 @ 2, 0, 2, 2)
behavior M():
    while True:
        take str(self.position in reg), str(reg.containsPoint(self.position)), str(self in reg)
ego = new Object with behavior M()
