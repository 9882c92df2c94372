#! id: requirement_on_angles
#! kind: static
#! tags: relative heading, apparent heading, chains
#! n: 400
ego = new Object at 0 @ 0
a = new Object at Range(1, 10) @ Range(1, 10), facing Range(0, 360) deg
require a.heading > 0
require -90 deg < (relative heading of a) < 90 deg
require (angle to a) < 0 and (apparent heading of a) > 0
