#! id: star_of_chosen_list
#! kind: static
#! n: 1200
shelves = [[1, 2], [4, 5, 6], [9]]
shelf = Uniform(*shelves)
ego = new Object at Uniform(*shelf, 20) @ 0
param size = len(shelf)
