#! id: beside_objects
#! kind: static
#! tags: left of, right of, ahead of, behind objects with sizes
#! n: 200
ego = new Object at 1 @ 2, facing 30 deg, with width 2, with length 5
a = new Object left of ego by 3, with width 3
b = new Object right of ego by Range(1, 3), with width 1
c = new Object ahead of ego by 3, with length 4
d = new Object behind ego by 2, with length 2, facing 80 deg
e = new Object ahead of d by 3 @ 4, with requireVisible False
