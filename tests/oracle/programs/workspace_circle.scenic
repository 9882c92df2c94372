#! id: workspace_circle
#! kind: static
#! tags: a round workspace
#! n: 400
workspace = Workspace(CircularRegion(0 @ 0, 10))
ego = new Object at Range(-10, 10) @ Range(-10, 10), with width 4, with length 2
