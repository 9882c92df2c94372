"""Shared by the defense games: the settings of an episode, and the behaviors of attackers without the built-in AI.

The agents move the left team, which defends its goal. Attackers have the built-in AI's highest difficulty.
"""

from football.behaviors import *

param game_duration = 400
param deterministic = False
param offsides = False
param end_episode_on_score = True
param end_episode_on_out_of_play = True
param end_episode_on_possession_change = True
param right_team_difficulty = 1
param defending = True

behavior Cross(start, receivers):
    """Run to a position on the wing and cross high to one of the receivers, sampled at that moment."""
    do MoveToPosition(start)
    do HighPassTo(Uniform(*receivers))
    do HoldPosition()

behavior ReceiveAndShoot(place):
    """Wait at a position for the ball, then dribble towards the goal and shoot."""
    do MoveToPosition(place)
    do HoldPosition() until self.owns_ball
    do dribbleToAndShoot(-80 @ 0)
    do HoldPosition()

behavior GoAtGoal(destination):
    """Dribble to the destination and shoot from the box; chase the ball while the other team has it."""
    try:
        do dribbleToAndShoot(destination)
    interrupt when left_penaltyBox.containsPoint(self.position):
        do AimGoalCornerAndShoot()
    interrupt when opponentTeamHasBallPossession(self):
        do FollowObject(simulation().game_ds.ball, sprint=True)
    do HoldPosition()

behavior PassHighAndFollow(receiver, first, second):
    """Pass high to the receiver, run to `first`, and then attack the goal by way of `second`."""
    try:
        do HighPassTo(receiver)
        do MoveToPosition(first, sprint=True)
        do GoAtGoal(second)
    interrupt when opponentTeamHasBallPossession(self):
        do FollowObject(simulation().game_ds.ball, sprint=True)
    do HoldPosition()

behavior Zigzag(destination, nearest, farthest):
    """Dribble towards the goal around opponents nearer than a sampled distance; chase a ball that escapes."""
    try:
        do dribbleToAndShoot(destination, reactionDistance=Range(nearest, farthest))
    interrupt when (distance from self to simulation().game_ds.ball) > 2:
        do FollowObject(simulation().game_ds.ball, sprint=True)
    do IdleBehavior()
