#! id: apparently_facing_random
#! kind: static
#! tags: apparently facing, relative headings
#! n: 500
r = CircularRegion(0 @ 0, 20)
ego = new Object in r
a = new Object ahead of ego by Range(1, 5), facing Range(-30, 30) deg relative to ego.heading
b = new Object left of ego by Range(1, 5), apparently facing Range(0, 90) deg
require (apparent heading of a) > 0
