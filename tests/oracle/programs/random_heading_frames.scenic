#! id: random_heading_frames
#! kind: static
#! tags: specifiers relative to objects with random heading
#! n: 500
ego = new Object at 0 @ 0, facing Range(0, 360) deg
a = new Object ahead of ego by 5
b = new Object left of ego by 4, facing 20 deg
param turn = relative heading of b
