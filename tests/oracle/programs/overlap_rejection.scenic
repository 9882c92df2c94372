#! id: overlap_rejection
#! kind: static
#! tags: objects that may not overlap
#! n: 500
ego = new Object at 0 @ 0, with width 4, with length 4
b = new Object at Range(-4, 4) @ Range(-4, 4), with width 2, facing Range(0, 90) deg
