#! id: noise_and_workspace
#! kind: static
#! tags: mutate, containment
#! n: 500
ego = new Object at 0 @ 0, with requireVisible False
workspace = Workspace(RectangularRegion(0 @ 0, 0, 4, 4))
mutate ego by 0.8
