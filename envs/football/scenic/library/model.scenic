"""The football world: the pitch and its regions, the ball, a class of player for each team and role.

x runs from -100 (the left goal) to 100 (the right goal), y from -42 to 42, +y up. The left team is the learner's and
attacks toward +x. Headings are 0 along +y and grow counterclockwise. Read next: behaviors.scenic.
"""

import math

param action_set = "v2"
param rewards = "scoring,checkpoints"
param stacked = False
param real_time = True
param physics_steps_per_frame = 10
param render_resolution_x = 1280

# The compass, as headings; the teams, as players' `team` reads.

north = 0
northwest = 45 deg
west = 90 deg
southwest = 135 deg
south = 180 deg
southeast = 225 deg
east = 270 deg
northeast = 315 deg

left_team = "left"
right_team = "right"

# The pitch.

field_width = 200
field_height = 84
inf_dist = 500

def get_reg_from_edges(left, right, top, bottom):
    """The upright rectangle between four edges, given in either order."""
    centre = ((left + right) / 2) @ ((top + bottom) / 2)
    return RectangularRegion(centre, 0, abs(right - left), abs(top - bottom))

def grid(row, column, grid_len=5):
    """One cell of the pitch, cut into grid_len parts along each axis."""
    width = field_width / grid_len
    height = field_height / grid_len
    return RectangularRegion(row * width @ column * height, 0, width, height)

field = RectangularRegion(0 @ 0, 0, field_width, field_height)
workspace = Workspace(field)

left_penaltyBox = get_reg_from_edges(-100, -71, 24, -24)
right_penaltyBox = get_reg_from_edges(71, 100, 24, -24)

left_goalRegion = RectangularRegion(-99.95 @ 0, 0, 0.1, 8.8)
right_goalRegion = RectangularRegion(99.95 @ 0, 0, 0.1, 8.8)
left_goal_midpoint = -100 @ 0
right_goal_midpoint = 100 @ 0
left_goal_left_corner = -100 @ -2.76
left_goal_right_corner = -100 @ 2.76
right_goal_left_corner = 100 @ 3
right_goal_right_corner = 100 @ -3

center = 0 @ 0
top_left_corner = -100 @ 42
top_right_corner = 100 @ 42
bottom_left_corner = -100 @ -42
bottom_right_corner = 100 @ -42

left_half_field = get_reg_from_edges(-95, 0, 38, -38)
right_half_field = get_reg_from_edges(0, 95, 38, -38)
left_bottom_half_field = get_reg_from_edges(-50, 0, 38, -38)
right_bottom_half_field = get_reg_from_edges(0, 50, 38, -38)

# The default region of each role. The right side is the left side, rotated by 180 degrees.

LeftReg_GK = get_reg_from_edges(-100, -98, 2, -2)
LeftReg_CB = get_reg_from_edges(-52, -48, 10, -10)
LeftReg_LB = get_reg_from_edges(-44, -42, 22, 18)
LeftReg_RB = get_reg_from_edges(-44, -42, -18, -22)
LeftReg_DM = get_reg_from_edges(-38, -32, 5, -5)
LeftReg_CM = get_reg_from_edges(-26, -22, 5, -5)
LeftReg_CML = get_reg_from_edges(-20, -16, 12, 8)
LeftReg_CMR = get_reg_from_edges(-20, -16, -8, -12)
LeftReg_CMM = get_reg_from_edges(-30, -24, 2, -2)
LeftReg_LM = get_reg_from_edges(-20, -16, 22, 18)
LeftReg_RM = get_reg_from_edges(-20, -16, -18, -22)
LeftReg_AM = get_reg_from_edges(-15, -10, 2, -2)
LeftReg_CF = get_reg_from_edges(-5, -1, 2, -2)

RightReg_GK = get_reg_from_edges(98, 100, 2, -2)
RightReg_CB = get_reg_from_edges(48, 52, 10, -10)
RightReg_LB = get_reg_from_edges(42, 44, -18, -22)
RightReg_RB = get_reg_from_edges(42, 44, 22, 18)
RightReg_DM = get_reg_from_edges(32, 38, 5, -5)
RightReg_CM = get_reg_from_edges(22, 26, 5, -5)
RightReg_CML = get_reg_from_edges(16, 20, -8, -12)
RightReg_CMR = get_reg_from_edges(16, 20, 12, 8)
RightReg_CMM = get_reg_from_edges(24, 30, 2, -2)
RightReg_LM = get_reg_from_edges(16, 20, -18, -22)
RightReg_RM = get_reg_from_edges(16, 20, 22, 18)
RightReg_AM = get_reg_from_edges(10, 15, 2, -2)
RightReg_CF = get_reg_from_edges(1, 5, 2, -2)

# The ball and the players.

class Ball:
    position[dynamic]: Point in field
    heading[dynamic]: 0
    width: 0.2
    length: 0.2
    direction[dynamic]: 0
    rotation[dynamic]: 0
    owned_team[dynamic]: -1
    owned_player_idx[dynamic]: -1
    allowCollisions: False
    requireVisible: False

class Player:
    position[dynamic]: Point in field
    heading[dynamic]: 0
    width: 1.0
    length: 1.0
    team: None
    role[dynamic]: Uniform("GK", "CB", "LB", "RB", "DM", "CM", "LM", "RM", "AM", "CF")
    direction[dynamic]: 0
    tired_factor[dynamic]: 0
    yellow_cards[dynamic]: 0
    red_card[dynamic]: False
    is_controlled[dynamic]: False
    owns_ball[dynamic]: False
    sticky_actions[dynamic]: []
    viewAngle: 360 deg
    visibleDistance: inf_dist
    allowCollisions: False
    requireVisible: False

class LeftPlayer(Player):
    team: "left"

class RightPlayer(Player):
    team: "right"

class LeftGK(LeftPlayer):
    role[dynamic]: "GK"
    position[dynamic]: Point in LeftReg_GK

class LeftCB(LeftPlayer):
    role[dynamic]: "CB"
    position[dynamic]: Point in LeftReg_CB

class LeftLB(LeftPlayer):
    role[dynamic]: "LB"
    position[dynamic]: Point in LeftReg_LB

class LeftRB(LeftPlayer):
    role[dynamic]: "RB"
    position[dynamic]: Point in LeftReg_RB

class LeftDM(LeftPlayer):
    role[dynamic]: "DM"
    position[dynamic]: Point in LeftReg_DM

class LeftCM(LeftPlayer):
    role[dynamic]: "CM"
    position[dynamic]: Point in LeftReg_CM

class LeftCML(LeftPlayer):
    role[dynamic]: "CM"
    position[dynamic]: Point in LeftReg_CML

class LeftCMR(LeftPlayer):
    role[dynamic]: "CM"
    position[dynamic]: Point in LeftReg_CMR

class LeftCMM(LeftPlayer):
    role[dynamic]: "CM"
    position[dynamic]: Point in LeftReg_CMM

class LeftLM(LeftPlayer):
    role[dynamic]: "LM"
    position[dynamic]: Point in LeftReg_LM

class LeftRM(LeftPlayer):
    role[dynamic]: "RM"
    position[dynamic]: Point in LeftReg_RM

class LeftAM(LeftPlayer):
    role[dynamic]: "AM"
    position[dynamic]: Point in LeftReg_AM

class LeftCF(LeftPlayer):
    role[dynamic]: "CF"
    position[dynamic]: Point in LeftReg_CF

class RightGK(RightPlayer):
    role[dynamic]: "GK"
    position[dynamic]: Point in RightReg_GK

class RightCB(RightPlayer):
    role[dynamic]: "CB"
    position[dynamic]: Point in RightReg_CB

class RightLB(RightPlayer):
    role[dynamic]: "LB"
    position[dynamic]: Point in RightReg_LB

class RightRB(RightPlayer):
    role[dynamic]: "RB"
    position[dynamic]: Point in RightReg_RB

class RightDM(RightPlayer):
    role[dynamic]: "DM"
    position[dynamic]: Point in RightReg_DM

class RightCM(RightPlayer):
    role[dynamic]: "CM"
    position[dynamic]: Point in RightReg_CM

class RightCML(RightPlayer):
    role[dynamic]: "CM"
    position[dynamic]: Point in RightReg_CML

class RightCMR(RightPlayer):
    role[dynamic]: "CM"
    position[dynamic]: Point in RightReg_CMR

class RightCMM(RightPlayer):
    role[dynamic]: "CM"
    position[dynamic]: Point in RightReg_CMM

class RightLM(RightPlayer):
    role[dynamic]: "LM"
    position[dynamic]: Point in RightReg_LM

class RightRM(RightPlayer):
    role[dynamic]: "RM"
    position[dynamic]: Point in RightReg_RM

class RightAM(RightPlayer):
    role[dynamic]: "AM"
    position[dynamic]: Point in RightReg_AM

class RightCF(RightPlayer):
    role[dynamic]: "CF"
    position[dynamic]: Point in RightReg_CF

# The names of the thesis: My is the learner's team, the left one.

class MyPlayer(LeftPlayer):
    pass

class MyGK(LeftGK):
    pass

class MyCB(LeftCB):
    pass

class MyLB(LeftLB):
    pass

class MyRB(LeftRB):
    pass

class MyDM(LeftDM):
    pass

class MyCM(LeftCM):
    pass

class MyCML(LeftCML):
    pass

class MyCMR(LeftCMR):
    pass

class MyCMM(LeftCMM):
    pass

class MyLM(LeftLM):
    pass

class MyRM(LeftRM):
    pass

class MyAM(LeftAM):
    pass

class MyCF(LeftCF):
    pass

class OpPlayer(RightPlayer):
    pass

class OpGK(RightGK):
    pass

class OpCB(RightCB):
    pass

class OpLB(RightLB):
    pass

class OpRB(RightRB):
    pass

class OpDM(RightDM):
    pass

class OpCM(RightCM):
    pass

class OpCML(RightCML):
    pass

class OpCMR(RightCMR):
    pass

class OpCMM(RightCMM):
    pass

class OpLM(RightLM):
    pass

class OpRM(RightRM):
    pass

class OpAM(RightAM):
    pass

class OpCF(RightCF):
    pass
