#! id: dictionaries_of_draws
#! kind: static
#! n: 900
spots = {"near": Range(1, 2), "far": Range(8, 9)}
marks = {k: 2 * v for k, v in spots.items()}
ego = new Object at spots["near"] @ marks["far"], with requireVisible False
b = new Object at 40 @ marks["near"], with requireVisible False
param gap = b.y - ego.x
