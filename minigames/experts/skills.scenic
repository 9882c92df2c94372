"""Shared by the semi-expert programs: the settings of an episode, conditions, and behaviors.

In programs for one agent (`agents_only`), the `active` agent follows the behavior of its player, and the built-in AI
moves the others. In programs for a team, every player with a behavior follows it.
"""

from football.behaviors import *

param game_duration = 400
param deterministic = False
param offsides = False
param end_episode_on_score = True
param end_episode_on_out_of_play = True
param end_episode_on_possession_change = True

def canShoot(player, opponent, target, near, far):
    """Whether the target is near, or not far with the opponent out of the way to it."""
    gap = distance from player to target
    lane = SectorRegion(player.position, 20, angle from player to target, 40 deg)
    return gap < near or (gap < far and not lane.containsPoint(opponent.position))

def safeSpot(player, opponent, target, turn=35 deg):
    """The one of two positions past the opponent, at a distance of 20, that is nearer to the target."""
    way = angle from player to opponent
    left = player.position offset along (way + turn) by 0 @ 20
    right = player.position offset along (way - turn) by 0 @ 20
    return left if (distance from left to target) < (distance from right to target) else right

behavior JustShoot():
    """With the ball near the goal, shoot straight or slightly turned; farther away, run at the goal."""
    while True:
        if self.owns_ball and (distance from self to right_goal_midpoint) < 30:
            first = Uniform(0, 5, 6)
            if first > 0:
                take SetDirection(first)
            take Shoot()
        elif self.owns_ball:
            take MoveTowardsPoint(right_goal_midpoint, self.position)
        else:
            take ReleaseDirection()

behavior SafePass(radius, width):
    """Pass to the nearest teammate who is not straight ahead."""
    if not self.owns_ball:
        take ReleaseDirection()
    else:
        ahead = SectorRegion(self.position, radius, self.heading, width)
        mates = [p for p in simulation().game_ds.left_players if p is not self and not ahead.containsPoint(p.position)]
        if len(mates) > 0:
            do ShortPassTo(get_closest_player_info(self, mates)[0])
        else:
            take NoAction()

behavior CloseInAndShoot(sprint):
    """Run at the goal, pass if an opponent is in the way, shoot from the box."""
    try:
        do MoveToPosition(99 @ 0, sprint=sprint)
    interrupt when opponentInRunway(self, reactionDistance=8):
        do SafePass(20, 0.5)
    interrupt when right_penaltyBox.containsPoint(self.position):
        do AimGoalCornerAndShoot()
    do IdleBehavior()

behavior StartCounterattack(winger, sprint):
    """Turn to the winger, pass, and join the attack."""
    for step in range(4):
        take SetDirection(6)
    take Pass("short")
    take ReleaseSprint()
    take ReleaseDirection()
    do CloseInAndShoot(sprint)
