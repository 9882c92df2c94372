#! id: noise_and_container
#! kind: static
#! tags: mutate, regionContainedIn, rebinding a name
#! n: 500
ego = new Object at 0 @ 0, facing 90 deg
b = new Object at 5 @ 0, with regionContainedIn RectangularRegion(5 @ 0, 0, 3, 3)
mutate b by 0.5
x = b
x = 3
