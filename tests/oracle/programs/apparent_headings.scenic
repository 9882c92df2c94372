#! id: apparent_headings
#! kind: static
#! tags: apparently facing
#! n: 200
ego = new Object at 0 @ 0
a = new Object at 10 @ Range(3, 5), apparently facing 30 deg from 2 @ 2
b = new Object at -10 @ 5, apparently facing -60 deg
