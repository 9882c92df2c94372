#! id: records; kind: dynamic
#! tags: record
#! steps: 4; sims: 1; drift: 1; timestep: 1
behavior C():
    while True:
        take 'c'
ego = new Object with behavior C()
record ego.position.y as y
record initial ego.position.y as y0
record final ego.position.y as y1
record ego.position.y > 2
record (distance from ego to 3 @ 4) as d
