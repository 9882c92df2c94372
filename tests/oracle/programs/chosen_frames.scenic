#! id: chosen_frames
#! kind: static
#! n: 900
a = new Object at 0 @ 2, facing 90 deg
b = new Object at 12 @ 1, facing -45 deg, with length 3
ego = a
near = Uniform(a, b)
c = new Object ahead of near by 2, with requireVisible False
d = new Object at near offset by 0 @ -4, with requireVisible False, with allowCollisions True
param h = near.heading, long = near.length
