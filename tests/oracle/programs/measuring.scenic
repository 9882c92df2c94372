#! id: measuring
#! kind: static
#! tags: distance, angle, relative heading, apparent heading
#! n: 200
ego = new Object at 0 @ 0, facing 20 deg
other = new Object at 6 @ 7, facing Range(60, 100) deg
third = new Object at -8 @ 3
param gap = distance to other
param gap_too = distance from other to third
param bearing = angle to other
param bearing_too = angle from third to other
param turn = relative heading of other
param turn_too = relative heading of other from third
param seen = apparent heading of other from third
param where = relative position of other from ego
