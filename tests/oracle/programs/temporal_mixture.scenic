#! id: temporal_mixture
#! kind: dynamic
#! steps: 8; sims: 200; drift: 1; timestep: 1
ego = new Object at 0 @ Range(0, 3)
require always ego.position.y < 9
require eventually ego.position.y > 6
require (ego.position.y < 5) until (ego.position.y >= 4)
terminate when ego.position.y >= 8
