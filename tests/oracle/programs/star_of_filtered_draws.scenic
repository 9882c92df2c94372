#! id: star_of_filtered_draws
#! kind: static
#! n: 1200
low = Range(0, 10)
high = Range(5, 15)
kept = filter(lambda v: v < 6, [low, high, 2])
ego = new Object at Uniform(*kept) @ len(kept)
