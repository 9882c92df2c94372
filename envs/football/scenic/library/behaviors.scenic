"""Behaviors for players of both teams, and queries about a match.

Every `take` is one step of 0.1 s. If a behavior has ended or waits, the built-in AI moves its player until the next
action; the actions of an agent override those of a behavior. Programs that import this file also import the model and
the actions.

Names and arguments are Scenic4RL's. Differences from Scenic4RL:

- The nearest player to a player is never that player, and None if there is no other; a player who stands exactly on the
  same spot counts. Without an opponent both corners of the goal are open.
- `currentDirectionIndex` uses counterclockwise headings, and returns the direction as the player sees the pitch.
- `nearestOpponentRelativePositionAhead` uses the player's heading for any direction of the run, and returns "none" if
  the nearest opponent is not ahead; `dribble_evasive_zigzag` then runs straight on, and never leaves the pitch.
- `dribbleToAndShoot` works for both teams (in Scenic4RL only the left penalty box triggers a shot), and supports sprint.
- `PassToPoint` rotates the direction for right players, uses the player's current position, and takes at least one step.
- `set_dir_if_not` compares actions by their numbers.

Read next: actions.scenic.
"""

import math

from football.model import *
from football.actions import *

# Queries about a match.

def opponentsOf(player):
    ds = simulation().game_ds
    return ds.left_players if player.team == "right" else ds.right_players

def teammatesOf(player):
    """The player's team, including the player."""
    ds = simulation().game_ds
    return ds.right_players if player.team == "right" else ds.left_players

def nearestOpponent(player):
    """The opponent closest to a player, keepers included; None if there is none."""
    return get_closest_player_info(player, opponentsOf(player))[0]

def nearestTeammate(player):
    """The teammate closest to a player, keepers included; None if there is none."""
    return get_closest_player_info(player, teammatesOf(player))[0]

def teammateHasBallPossession(player):
    """Whether the player or a teammate owns the ball."""
    for mate in teammatesOf(player):
        if mate.owns_ball:
            return True
    return False

def opponentTeamHasBallPossession(player):
    for opponent in opponentsOf(player):
        if opponent.owns_ball:
            return True
    return False

def opponentInRunway(player, reactionDistance=5):
    """Whether an opponent stands in the quarter disc of this radius in front of the player."""
    runway = SectorRegion(player.position, reactionDistance, player.heading, 90 deg)
    for opponent in opponentsOf(player):
        if runway.containsPoint(opponent.position):
            return True
    return False

def nearestOpponentRelativePositionAhead(player):
    """The side of the nearest opponent, seen along the player's heading: "left", "right", or "none" if not ahead."""
    opponent = nearestOpponent(player)
    if opponent is None:
        return "none"
    bearing = normalizeAngle((angle from player to opponent) - player.heading)
    if abs(bearing) > 90 deg:
        return "none"
    return "left" if bearing >= 0 else "right"

def currentDirectionIndex(player):
    """The direction, 1 to 8, nearest to a player's heading, as the player sees the pitch."""
    turned = 4 if player.team == "right" else 0
    return (2 + turned - round(player.heading / (45 deg))) % 8 + 1

def set_dir_if_not(action, sticky_actions):
    """The action, or NoAction() if it is the direction already held."""
    if 1 <= action <= 8:
        return NoAction() if sticky_actions[action - 1] == 1 else action
    return action

def cornersToShootAt(player):
    """The targets of shots at the goal that a player attacks: its left and its right corner."""
    if player.team == "right":
        return left_goal_left_corner, left_goal_right_corner
    return right_goal_left_corner, right_goal_right_corner

def cornerIsOpen(player, corner, width):
    """Whether the nearest opponent stands outside the sector of this width from the player to the corner."""
    opponent = nearestOpponent(player)
    if opponent is None:
        return True
    length = distance from player to corner
    course = angle from player to corner
    return not SectorRegion(player.position, length, course, width).containsPoint(opponent.position)

def aimPointToShoot(player, angle=30 deg, otherwise=None):
    """An open corner of the goal, a random one if both are open; `otherwise` if the nearest opponent covers both."""
    left_corner, right_corner = cornersToShootAt(player)
    left_open = cornerIsOpen(player, left_corner, angle)
    right_open = cornerIsOpen(player, right_corner, angle)
    if left_open and right_open:
        return Uniform(left_corner, right_corner)
    if left_open:
        return left_corner
    if right_open:
        return right_corner
    return otherwise

def fartherCorner(player):
    left_corner, right_corner = cornersToShootAt(player)
    nearer_the_right = (distance from player to left_corner) > (distance from player to right_corner)
    return left_corner if nearer_the_right else right_corner

def attackedBox(player):
    """The penalty box in front of the goal that a player attacks."""
    return left_penaltyBox if player.team == "right" else right_penaltyBox

# Behaviors.

behavior IdleBehavior():
    """Take no action; sticky actions stay active."""
    while True:
        take NoAction()

behavior HoldPosition():
    """Stand still."""
    while True:
        take ReleaseSprint()
        take ReleaseDirection()

behavior BuiltinAIBot():
    while True:
        take BuiltinAIAction()

behavior RunRight():
    """Run towards the opponents' goal."""
    while True:
        take SetDirection(ActionCode.right)

behavior MoveToPosition(dest_point, reaction_dist=2, sprint=False):
    """Run to the destination's current position; with sprint, the behavior ends at a distance of 10."""
    x = dest_point.x
    y = dest_point.y
    arrival = 10 if sprint else reaction_dist
    while (distance from self to (x @ y)) > arrival:
        take MoveTowardsPoint(x @ y, self.position, self.team == "right")
        if sprint:
            take Sprint()
    if sprint:
        take ReleaseSprint()
    take ReleaseDirection()

behavior FollowObject(object_to_follow, terminate_distance=1, sprint=False):
    """Run to the object's position in each step."""
    while (distance from self to object_to_follow) > terminate_distance:
        take MoveTowardsPoint(object_to_follow.position, self.position, self.team == "right")
        if sprint:
            take Sprint()
    if sprint:
        take ReleaseSprint()
    take ReleaseDirection()

behavior ShortPassTo(player):
    take MoveTowardsPoint(player.position, self.position, self.team == "right")
    take Pass("short")
    take ReleaseSprint()
    take ReleaseDirection()

behavior HighPassTo(player):
    take MoveTowardsPoint(player.position, self.position, self.team == "right")
    take Pass("high")
    take ReleaseSprint()
    take ReleaseDirection()

behavior LongPassTo(player):
    take MoveTowardsPoint(player.position, self.position, self.team == "right")
    take Pass("long")
    take ReleaseSprint()
    take ReleaseDirection()

behavior PassToPlayer(player, pass_type="long"):
    """Pass to the player's current position."""
    do PassToPoint(player.position.x, player.position.y, pass_type)

behavior PassToPoint(x, y, pass_type="long"):
    """While owning the ball: turn towards the point and kick, "long", "short", "high" or "shoot"."""
    if not self.owns_ball:
        take NoAction()
    while self.owns_ball:
        take MoveTowardsPoint(x @ y, self.position, self.team == "right")
        take Shoot() if pass_type == "shoot" else Pass(pass_type)

behavior AimGoalCornerAndShoot():
    """Stop, turn to an open corner of the goal, or the farther one if both are covered, and shoot."""
    take ReleaseSprint()
    take ReleaseDirection()
    aim = aimPointToShoot(self, otherwise=fartherCorner(self))
    take MoveTowardsPoint(aim, self.position, self.team == "right")
    take Shoot()
    take ReleaseSprint()
    take ReleaseDirection()

behavior dribble_evasive_zigzag(destination_point):
    """Run past the nearest opponent ahead on the free side, then sprint to the destination."""
    side = nearestOpponentRelativePositionAhead(self)
    if side != "none":
        turn = 45 deg if side == "right" else -45 deg
        way = self.position offset along (self.heading + turn) by 0 @ Range(10, 15)
        do MoveToPosition(max(-98, min(98, way.x)) @ max(-40, min(40, way.y)))
        take ReleaseDirection()
    do MoveToPosition(destination_point, sprint=True)
    take ReleaseSprint()
    take ReleaseDirection()

behavior dribbleToAndShoot(destination_point, sprint=False, reactionDistance=None):
    """Run to the destination, evade opponents on the way, shoot from the opponents' penalty box."""
    reaction = reactionDistance if reactionDistance is not None else Range(15, 20) if sprint else Range(10, 15)
    try:
        do MoveToPosition(destination_point, sprint=sprint)
    interrupt when opponentInRunway(self, reaction):
        do dribble_evasive_zigzag(destination_point)
    interrupt when attackedBox(self).containsPoint(self.position):
        do AimGoalCornerAndShoot()
