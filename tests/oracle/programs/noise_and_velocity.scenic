#! id: noise_and_velocity
#! kind: static
#! tags: mutate, velocity
#! n: 500
#! props: speed,velocity
ego = new Object at 0 @ 0, facing 20 deg, with speed 3
mutate
