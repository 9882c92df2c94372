#! id: locals_of_a_setup
#! kind: static
#! n: 900
yard = RectangularRegion(0 @ 0, 0, 24, 24)
workspace = Workspace(yard)
scenario Main():
    setup:
        ego = new Object in yard, with requireVisible False
        width = Range(1, 3)
        friend = new Object right of ego by width, with requireVisible False
        require friend.x > 4
        require width < 2.5
        param width = width
