#! id: sides_of_objects
#! kind: static
#! tags: front of, back left of
#! n: 100
ego = new Object at 2 @ 1, facing 30 deg, with width 4, with length 6
a = new Object at (front of ego) offset by 0 @ 3
b = new Object ahead of (front right of ego) by 4
spot = back left of ego
param x = spot.position, h = spot.heading
