"""What the defences share: the settings of an episode, and what attackers do who do not leave it to the built-in AI.

The learner's team is the left one, before whose goal all this happens. Attackers are as good as the built-in AI gets.
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
    """Run to a place on the wing and cross high to one of the receivers, drawn at that moment."""
    do MoveToPosition(start)
    do HighPassTo(Uniform(*receivers))
    do HoldPosition()

behavior ReceiveAndShoot(place):
    """Wait at a place for the ball, then go at the goal."""
    do MoveToPosition(place)
    do HoldPosition() until self.owns_ball
    do dribbleToAndShoot(-80 @ 0)
    do HoldPosition()

behavior GoAtGoal(destination):
    """Carry the ball to the destination and shoot from the box; run after a ball that the other team has."""
    try:
        do dribbleToAndShoot(destination)
    interrupt when left_penaltyBox.containsPoint(self.position):
        do AimGoalCornerAndShoot()
    interrupt when opponentTeamHasBallPossession(self):
        do FollowObject(simulation().game_ds.ball, sprint=True)
    do HoldPosition()

behavior PassHighAndFollow(receiver, first, second):
    """Pass high to the receiver, run to one place, from there to another like him who goes at the goal."""
    try:
        do HighPassTo(receiver)
        do MoveToPosition(first, sprint=True)
        do GoAtGoal(second)
    interrupt when opponentTeamHasBallPossession(self):
        do FollowObject(simulation().game_ds.ball, sprint=True)
    do HoldPosition()

behavior Zigzag(destination, nearest, farthest):
    """Go at the goal, round whoever comes nearer than a distance drawn anew; run after a ball that got away."""
    try:
        do dribbleToAndShoot(destination, reactionDistance=Range(nearest, farthest))
    interrupt when (distance from self to simulation().game_ds.ball) > 2:
        do FollowObject(simulation().game_ds.ball, sprint=True)
    do IdleBehavior()
