spawn_area = get_reg_from_edges(0, 80, -25, 25)

ego = LeftCM on spawn_area
opponent = RightGK on spawn_area

MyGK
ball = Ball ahead of ego by 2
