#! id: noise_by_several_statements
#! kind: static
#! tags: mutate of all, then of one
#! n: 500
ego = new Object at 0 @ 0
mutate
b = new Object at Range(3, 4) @ 0
mutate b by 2
mutate ego by 0.1
