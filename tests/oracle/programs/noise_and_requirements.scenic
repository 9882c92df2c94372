#! id: noise_and_requirements
#! kind: static
#! tags: mutate, a requirement before and after it
#! n: 500
ego = new Object at 0 @ 0
b = new Object at 5 @ Range(0, 3)
require b.x > 5
mutate b
require b.y > 1
