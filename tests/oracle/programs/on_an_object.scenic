#! id: on_an_object
#! kind: static
#! tags: on an object
#! n: 300
ego = new Object at 3 @ 4
b = new Object on ego, with allowCollisions True
