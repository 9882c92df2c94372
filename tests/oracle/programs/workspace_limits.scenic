#! id: workspace_limits
#! kind: static
#! tags: containment in the workspace and regionContainedIn
#! n: 500
workspace = Workspace(RectangularRegion(0 @ 0, 0, 20, 20))
ego = new Object at Range(-12, 12) @ 0, facing 45 deg
b = new Object at 5 @ Range(-10, 10), with regionContainedIn CircularRegion(5 @ 0, 4), with allowCollisions True
