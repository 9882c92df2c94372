#! id: two_line_specifiers
#! kind: static
#! tags: specifiers over several lines, comments between
#! n: 100
ego = new Object at 1 @ 2,
    with width 2,   # broad

    with length Range(1, 3),
    facing 20 deg
other = new Object at (
    10 @
    3
), with requireVisible False
