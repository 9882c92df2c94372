#! id: view_and_big_box
#! kind: static
#! tags: requireVisible, an object larger than the view
#! n: 500
ego = new Object at 0 @ 0, with visibleDistance 8
a = new Object at Range(-12, 12) @ Range(-12, 12), with width 12, with length 10, with allowCollisions True
