#! id: random_side_of_an_object
#! kind: static
#! tags: sides, Uniform of oriented points, offset by
#! n: 500
ego = new Object at 0 @ 0, facing 10 deg
sides = [front of ego, back of ego, left of ego]
a = new Object ahead of sides[0] by 1
b = new Object at Uniform(*sides) offset by 0 @ 20
