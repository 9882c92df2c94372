#! id: lazy_defaults
#! kind: static
#! tags: defaults that depend on each other and on position
#! props: reach,far; n: 300
class Post:
    reach: self.width + 1
    far: self.position.x * self.reach
    width: Range(1, 2)
ego = new Post at Range(5, 9) @ 0
b = new Post at -9 @ 0, with width 3
