#! id: truncated_normal_random_mean
#! kind: static
#! tags: TruncatedNormal and Normal with random moments
#! n: 500
mean = Range(0, 3)
ego = new Object at TruncatedNormal(mean, 1, 0, 4) @ Normal(mean, Range(1, 2)), with requireVisible False
