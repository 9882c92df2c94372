"""Four strategies against three attackers; a selector in [0, 1] chooses one (thesis, section 4.3).

Each reads the state of the match at every step. Defenders sprint to a target that is more than 10 away.
"""

from football.behaviors import *

behavior Defend(selector):
    """A below 0.25, B below 0.5, C below 0.75, else D."""
    if selector < 0.25:
        do ChaseBall()
    elif selector < 0.5:
        do MarkOwner()
    elif selector < 0.75:
        do CutLane()
    else:
        do GuardGoal()

behavior ChaseBall():
    """A: run at the ball; close to it slide, once every 10 steps at most."""
    since_slide = 10
    while True:
        ball = simulation().game_ds.ball
        if since_slide >= 10 and not self.owns_ball and (distance from self to ball) < 1:
            since_slide = 0
            take Slide()
        else:
            since_slide = since_slide + 1
            take keyTowards(self, ball)

behavior MarkOwner():
    """B: run at the attacker who owns the ball or owned it last; at the ball if no attacker has owned it yet."""
    marked = None
    while True:
        owner = player_with_ball(simulation().game_ds, simulation().game_ds.ball, "left")
        if owner is not None:
            marked = owner
        if marked is None:
            take keyTowards(self, simulation().game_ds.ball)
        else:
            take keyTowards(self, marked)

behavior CutLane():
    """C: run into the lane between two attackers; once there, or after 30 steps, chase the ball."""
    steps = 0
    while steps < 30 and (distance from self to laneToCut(self)) >= 2:
        steps = steps + 1
        take keyTowards(self, laneToCut(self))
    do ChaseBall()

behavior GuardGoal():
    """D: stand between ball and goal; chase a ball that comes within 6, until it is farther than 10."""
    try:
        do StandBeforeGoal()
    interrupt when (distance from self to simulation().game_ds.ball) < 6:
        do ChaseBall() until (distance from self to simulation().game_ds.ball) > 10

behavior StandBeforeGoal():
    while True:
        spot = spotBeforeGoal(simulation().game_ds.ball)
        if (distance from self to spot) < 1:
            take ReleaseDirection()
        else:
            take keyTowards(self, spot)

def keyTowards(player, target):
    """The next action on the way to an object or point."""
    far = (distance from player to target) > 10
    if far and not player.sticky_actions[8]:
        return Sprint()
    if player.sticky_actions[8] and not far:
        return ReleaseSprint()
    return MoveTowardsPoint(target, player.position, player.team == "right")

def laneToCut(defender):
    """The midpoint between the attacker closest to the defender and the easiest receiver of a pass."""
    ds = simulation().game_ds
    owner = player_with_ball(ds, ds.ball, "left")
    if owner is None:
        owner = closestTo(ds.ball, ds.left_players)
    near = closestTo(defender, ds.left_players)
    mate = get_closest_player_info(owner, ds.left_players)[0]
    other = ds.ball.position if mate is near else mate.position
    return (near.position + other) / 2

def closestTo(place, players):
    return get_closest_player_info(place, players)[0]

def spotBeforeGoal(ball):
    """The point at x = 96 on the line from the ball to the middle of the goal, clipped to |y| <= 3.5."""
    y = ball.y * 4 / max(4, 100 - ball.x)
    return 96 @ max(-3.5, min(3.5, y))
