#! id: area_workspace_diff
#! kind: static
#! tags: regions, workspace diff
#! n: 600
r = RectangularRegion(0@0,0,20,20).difference(CircularRegion(0@0,4))
workspace = Workspace(r)
ego = new Object in workspace, with width 4, with length 4, with requireVisible False, with allowCollisions True
