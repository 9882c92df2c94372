"""What the gauntlet's programs share: the settings of an episode, guards who wake when the ball comes near, courses.

A course is what stands around the striker, in the order of the training program.
"""

from football.behaviors import *

param game_duration = 300
param deterministic = False
param offsides = False
param end_episode_on_score = True
param end_episode_on_out_of_play = True
param end_episode_on_possession_change = True

behavior Guard(reach):
    """Run at a ball that is within reach, at full speed from afar; else stand."""
    while True:
        gap = distance from self to simulation().game_ds.ball
        if gap > reach:
            take ReleaseSprint()
            take ReleaseDirection()
        elif gap > 8 and not self.sticky_actions[8]:
            take Sprint()
        elif gap <= 8 and self.sticky_actions[8]:
            take ReleaseSprint()
        else:
            take MoveTowardsPoint(simulation().game_ds.ball, self.position, True)

def between(start, share, aside):
    """The place at this share of the way from a start to the goal, so far aside of it."""
    return (start.x + share * (97 - start.x)) @ ((1 - share) * start.y + aside)

def course(ego, reach):
    """Three guards on the way to the goal, always in the same places, all of the same reach."""
    LeftGK at -99 @ 0
    RightGK at 99 @ 0
    RightCB at between(ego, 0.27, 3), with behavior Guard(reach)
    RightCB at between(ego, 0.5, -3), with behavior Guard(reach)
    RightCB at between(ego, 0.72, 2), with behavior Guard(reach)
    Ball ahead of ego by 2

def random_course(ego, least, most):
    """Three guards on the way to the goal as in training, but each of a reach between these."""
    LeftGK at -99 @ 0
    RightGK at 99 @ 0
    RightCB at between(ego, Range(0.2, 0.35), Range(-6, 6)), with behavior Guard(Range(least, most))
    RightCB at between(ego, Range(0.4, 0.6), Range(-6, 6)), with behavior Guard(Range(least, most))
    RightCB at between(ego, Range(0.65, 0.8), Range(-6, 6)), with behavior Guard(Range(least, most))
    Ball ahead of ego by 2

def three_lines(ego, least, most):
    """A guard in each of three lines, each of a reach between these."""
    LeftGK at -99 @ 0
    RightGK at 99 @ 0
    RightCB on get_reg_from_edges(10, 30, -15, 15), with behavior Guard(Range(least, most))
    RightCB on get_reg_from_edges(40, 60, -15, 15), with behavior Guard(Range(least, most))
    RightCB on get_reg_from_edges(65, 85, -15, 15), with behavior Guard(Range(least, most))
    Ball ahead of ego by 2
