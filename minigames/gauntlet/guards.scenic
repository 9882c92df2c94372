"""Shared by the gauntlet programs: the settings of an episode, guards that react to a near ball, and chasers."""

from football.behaviors import *

param game_duration = 300
param deterministic = False
param offsides = False
param end_episode_on_score = True
param end_episode_on_out_of_play = True
param end_episode_on_possession_change = True

behavior Guard(reach):
    """Run at a ball within `reach`, and sprint if it is more than 8 away; else stand."""
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

behavior Chase(pace):
    """Run at the ball in a share `pace` of every ten steps, and stand in the others. Never sprint."""
    step = 0
    while True:
        if step < 10 * pace:
            take MoveTowardsPoint(simulation().game_ds.ball, self.position, True)
        else:
            take ReleaseDirection()
        step = (step + 1) % 10

def between(start, share, aside):
    """The point at `share` of the way from a start to the goal, at a lateral distance `aside` from that line."""
    return (start.x + share * (97 - start.x)) @ ((1 - share) * start.y + aside)
