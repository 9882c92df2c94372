#! id: stars_of_two_lists
#! kind: static
#! n: 1200
left = Uniform([1, 2], [3])
right = Uniform((10,), (20, 30, 40))
ego = new Object at Uniform(*left, *right) @ Uniform(*right, *[5, 6])
