#! id: point_objects
#! kind: static
#! tags: Point and OrientedPoint as references
#! n: 300
mark = new Point at Range(0, 4) @ 2
arrow = new OrientedPoint at 8 @ 8, facing Range(0, 90) deg
ego = new Object at mark offset by 0 @ 10
b = new Object ahead of arrow by 5
c = new Object at arrow offset by 10 @ 0, facing arrow.heading, with requireVisible False
