"""Scenes of the regression test of the football simulator: drawn programs, grouped by the events that they provoke.

The scenes cover matches of eleven, open play of 2 to 17 players under all control modes, attacks, and balls near the
lines. They also cover duels, balls in flight, shots at keepers, and balls struck at opponents close by. The rest are
each kind of restart, library behaviors, and engines with other factors. A scene is the text of a program with random
numbers. `lab/record_football.py` plays and stores the scenes:

    python -m lab.record_football --draw
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from regista.envs.football.constants import (
    CORNER,
    FREE_KICK,
    GOAL_KICK,
    LEFT,
    METRES_PER_X,
    METRES_PER_Y,
    PENALTY,
    RIGHT,
    THROW_IN,
)
from scenic_lite import ScenicError
from tests.envs.played import LETTERS, Scene, make_env

Rng = np.random.Generator
Place = tuple[float, float]  # m
ROLES = ("CB", "LB", "RB", "DM", "CM", "LM", "RM", "AM", "CF")
STEPS, CANDIDATES = 80, 16  # steps of a scene; candidate rows, of which some are chosen
TRIES = 1_000
# Actions as letters: a idle, b to i directions (f to the right), j long, k high and l short pass, m shot, n sprint,
# q slide, r dribble, o, p and s releases
SHOOTS = LETTERS + "mmmmmmefffgnn"
PASSES = LETTERS + "jjjkkklllll"
SLIDES = LETTERS + "qqqqqqqqffbbnn"
DRIBBLES = LETTERS[:9] * 2 + "nnprrsoa"
SPRINTS = "ffffffeegnnnno"
FORMATION = (
    *(("GK", -54, 0), ("CB", -40, -6), ("CB", -40, 6), ("LB", -36, 20), ("RB", -36, -20), ("DM", -25, 0)),
    *(("CM", -14, 9), ("CM", -14, -9), ("LM", -8, 22), ("RM", -8, -22), ("CF", -2, 1.5)),
)
BEHAVIORS = (
    *("dribbleToAndShoot(right_goal_midpoint)", "dribbleToAndShoot(right_goal_midpoint, sprint=True)", "RunRight()"),
    *("FollowObject(ball)", "FollowObject(ball, sprint=True)", "HoldPosition()", "BuiltinAIBot()", "IdleBehavior()"),
    *("MoveToPosition(80 @ 10, sprint=True)", "AimGoalCornerAndShoot()", "dribble_evasive_zigzag(95 @ 0)"),
    *("PassToPoint(70, 5)", 'PassToPoint(60, -10, "short")', 'PassToPoint(85, 20, "high")', "Several()"),
)
SEVERAL = """
behavior Several():
    while True:
        take SetDirection(5), Sprint()
        take SetDirection(4), Dribble(), ReleaseSprint()
        take ReleaseDirection(), ReleaseDribble()
        take SetDirection(6), Sprint(), Shoot()
"""


class Person(NamedTuple):
    """A player of a program, at (x, y) m."""

    who: str
    x: float
    y: float
    behavior: str = ""


class Draw(NamedTuple):
    """A draw of a program: parameters, the ball's position in m, players, and text before them."""

    params: dict[str, Any]
    ball: Place
    people: Sequence[Person]
    head: str = ""

    def text(self) -> str:
        """Return the program."""
        lines = [*self.head.splitlines(), *(f"param {name} = {value}" for name, value in self.params.items())]
        lines.append(f"ball = Ball at {within(*self.ball)}")
        for k, person in enumerate(self.people):
            behavior = f", with behavior {person.behavior}" if person.behavior else ""
            lines.append(f"p{k} = {person.who} at {within(person.x, person.y)}{behavior}")
        return "\n".join([*lines, "ego = p0"]) + "\n"


def within(x: float, y: float) -> str:
    """Return a position in m in the units of programs, clipped to the pitch."""
    units = np.clip((x / METRES_PER_X, y / METRES_PER_Y), (-99.0, -41.0), (99.0, 41.0))
    return f"{units[0]:.1f} @ {units[1]:.1f}"


def scene(
    rng: Rng,
    name: str,
    draw: Callable[[], Draw],
    urn: str = LETTERS,
    control: tuple[str, str] = ("closest1", "none"),
    **others: Any,
) -> Scene:
    """Return a scene of a playable program; `others` are fields of `Scene`, or settings.

    Raises ValueError if none of many draws is playable.
    """
    fields: dict[str, Any] = {"steps": STEPS, "hold": 0.7, "spread": 0.6, "start": {}, "scripted": False}
    given = {key: others.pop(key) for key in list(others) if key in fields}
    settings = {"control": control[0], "right_control": control[1], **others}
    seeds = tuple(int(rng.integers(2**30)) + k for k in range(CANDIDATES))
    for _ in range(TRIES):
        drawn = Scene(name, draw().text(), settings, urn=urn, seeds=seeds, **fields | given)
        try:
            make_env(drawn)
        except (ScenicError, ValueError) as error:
            last = error
            continue
        return drawn
    raise ValueError(f"no program of {name} can be played: {last}") from last


# ---------------------------------------------------------------- players


def rules(rng: Rng, **others: Any) -> dict[str, Any]:
    """Return drawn parameters of a match, updated by `others`."""
    left, right = rng.choice([0.05, 0.3, 0.6, 0.8, 1.0], 2).tolist()
    drawn = {"left_team_difficulty": left, "right_team_difficulty": right, "offsides": bool(rng.random() < 0.6)}
    return {"game_duration": 3000, **drawn, **others}


def crowd(rng: Rng, team: str, count: int, middle: Place, spread: float) -> list[Person]:
    """Return `count` outfield players around a position."""
    return [Person(team + str(rng.choice(ROLES)), *rng.normal(middle, spread).tolist()) for _ in range(count)]


def keeper(rng: Rng, team: str) -> Person:
    """Return a keeper, usually near its own goal."""
    side = -1 if team == "Left" else 1
    return Person(f"{team}GK", side * (54.0 - rng.exponential(4.0)), float(rng.normal(0.0, 2.0)))


def keepers(rng: Rng) -> list[Person]:
    """Return both keepers."""
    return [keeper(rng, "Left"), keeper(rng, "Right")]


def eleven(team: str, push: float = 0.0, count: int = 11) -> list[Person]:
    """Return a team in its formation, moved `push` m to the right."""
    side = -1 if team == "Right" else 1
    return [Person(team + role, side * x + push, side * y) for role, x, y in FORMATION[:count]]


# ---------------------------------------------------------------- families


def matches(rng: Rng) -> Iterator[Scene]:
    """Yield matches of eleven a side: from the kick-off, or with the ball and both teams at random positions."""
    ways: tuple[tuple[tuple[str, str], dict[str, Any]], ...] = (
        (("closest1", "none"), {"scripted": True}),
        (("all", "none"), {"representation": "simple115"}),
        (("active", "active"), {"representation": "smm"}),
        (("closest3", "closest2"), {"representation": "smm_stacked"}),
        (("none", "3"), {"scripted": True, "representation": "simple115"}),
        (("allNonGK", "closest1"), {"representation": "features"}),
    )
    for k, (control, others) in enumerate(ways):
        push = float(rng.uniform(-30, 30)) if k % 2 else 0.0

        def draw(push: float = push, k: int = k) -> Draw:
            half = {"second_half": 40} if k in (0, 3) else {}
            ball = (push + float(rng.normal(0, 3)), float(rng.normal(0, 8)))
            return Draw(rules(rng, **half), ball, eleven("Left", push) + eleven("Right", push))

        more = {"rewards": "scoring,checkpoints", "steps": 2 * STEPS}
        yield scene(rng, f"match {k}", draw, PASSES, control, **more, **others)


def open_play(rng: Rng) -> Iterator[Scene]:
    """Yield teams of drawn sizes around the ball, under all control modes."""
    ways = (
        *(("closest1", "closest1"), ("closest2", "none"), ("closest3", "none"), ("active", "active")),
        *(("all", "all"), ("allNonGK", "none"), ("2", "2"), ("1", "closest3")),
    )
    for k, control in enumerate(ways):
        left, right = int(rng.integers(3, 9)), int(rng.integers(3, 8)) if k != 2 else 0
        middle, spread = rng.uniform((-40, -25), (40, 25)).tolist(), float(rng.uniform(5, 20))

        def draw(left: int = left, right: int = right, middle: Place = middle, spread: float = spread) -> Draw:
            first = crowd(rng, "Left", left, middle, spread)
            people = [*first, *crowd(rng, "Right", right, middle, spread), *keepers(rng)]
            return Draw(rules(rng), (first[0].x + 1.5, first[0].y), people)

        urn, seen = (LETTERS, PASSES, DRIBBLES)[k % 3], ("features", "simple115")[k % 2]
        yield scene(rng, f"open {k}", draw, urn, control, rewards="scoring,checkpoints", representation=seen)


def attacks(rng: Rng) -> Iterator[Scene]:
    """Yield a striker before the goal with teammates, backs and a keeper; in two scenes the right team attacks."""
    controls = (("closest1", "none"), ("all", "none"), ("active", "none"), ("closest1", "1"))
    for k in range(8):
        away, y, side = float(rng.uniform(8, 32)), float(rng.normal(0, 10)), -1.0 if k % 4 == 3 else 1.0
        own, other = ("Right", "Left") if side < 0 else ("Left", "Right")

        def draw(x: float = side * (55.0 - away), y: float = y, own: str = own, other: str = other, k: int = k) -> Draw:
            people = [Person(f"{own}CF", x - np.sign(x) * 1.2, y), keeper(rng, other)]
            people += crowd(rng, own, k % 3, (x, -y / 2), 8.0)
            people += crowd(rng, other, k // 2, (x * 1.1, y * 0.7), 5.0)
            return Draw(rules(rng), (x, y), people if own == "Left" else [*people, keeper(rng, own)])

        yield scene(rng, f"attack {k}", draw, SHOOTS, controls[k % 4])


def lines(rng: Rng) -> Iterator[Scene]:
    """Yield scenes with the ball at a line, and players of both teams around it."""
    places = ((30.0, 35.0), (54.3, 10.0), (-54.3, -20.0), (-45.0, -35.0))
    for k, (x, y) in enumerate(places):

        def draw(x: float = x, y: float = y, k: int = k) -> Draw:
            team = ("Left", "Right")[k // 2]
            people = [Person(f"{team}CM", 0.98 * x, 0.97 * y), *keepers(rng)]
            people += crowd(rng, "Left", 2 + k, (x * 0.8, y * 0.7), 9.0)
            people += crowd(rng, "Right", 2 + k % 3, (x * 0.8, y * 0.6), 9.0)
            return Draw(rules(rng), (x, y), people)

        controls = (("closest1", "closest1"), ("all", "all"))
        yield scene(rng, f"line {k}", draw, (PASSES, SHOOTS)[k % 2], controls[k % 2])


def duels(rng: Rng) -> Iterator[Scene]:
    """Yield a player with the ball, and sliding opponents nearby: in the middle, in both boxes, on a wing."""
    controls = (("all", "all"), ("closest1", "closest1"), ("all", "none"), ("none", "all"))
    for k in range(8):
        x, y = ((0.0, 0.0), (46.0, 5.0), (-46.0, -6.0), (20.0, 30.0))[k % 4]

        def draw(x: float = x, y: float = y, k: int = k) -> Draw:
            owner, rival = ("Left", "Right") if k % 3 else ("Right", "Left")
            way = 1.0 if owner == "Left" else -1.0
            people = [Person(f"{owner}CF", x - 0.7 * way, y), Person(f"{rival}CB", x + 2.5 * way, y + 0.5)]
            people += [Person(f"{rival}LB", x - 2.8 * way, y - 0.5), Person(f"{rival}RB", x + 4.0 * way, y - 2.0)]
            return Draw(rules(rng), (x, y), [*people, *keepers(rng), *crowd(rng, owner, k % 3, (x, y), 8.0)])

        urn = SLIDES if k % 4 != 3 else DRIBBLES
        yield scene(rng, f"duel {k}", draw, urn, controls[k // 2], spread=1.0)


def runs(rng: Rng) -> Iterator[Scene]:
    """Yield a player who sprints with the ball at built-in backs, or at a keeper who has come out of the box."""
    for k in range(4):
        x = (5.0, 20.0, 30.0, 22.0)[k]

        def draw(x: float = x, k: int = k) -> Draw:
            people = [Person("LeftCF", x - 1.2, 0.5)]
            if k < 2:
                people += [Person(f"Right{ROLES[back]}", x + 6.0 + 5.0 * back, 2.0 * back - 1.0) for back in range(3)]
                return Draw(rules(rng), (x, 0.5), [*people, keeper(rng, "Right")])
            return Draw(rules(rng), (x, 0.5), [*people, Person("RightGK", x + 9.0, 0.0)])

        yield scene(rng, f"run {k}", draw, SPRINTS, spread=1.2, hold=0.8)


def cards(rng: Rng) -> Iterator[Scene]:
    """Yield players with cards: sliding players with one card, players sent off, and two players in the same place."""
    backs = ((-2.0, 0.5), (2.6, -0.5)), ((0.4, 1.4), (0.6, -1.5))  # before and behind the carrier, or on both sides
    # players in the order of a match: keepers first, the left team before the right one
    ways = (
        ("all", backs[0], {"1.cards": (1, 1), "2.cards": (1, 1)}),
        ("2", backs[0], {"1.cards": (2, 2), "1.leave_wait": (0.1, 2.0), "4.cards": (2, 2), "4.leave_wait": (0.5, 3.0)}),
        ("1", backs[0], {"1.x": (3.0, 3.0), "1.y": (1.0, 1.0), "2.x": (3.0, 3.0), "2.y": (1.0, 1.0)}),
        ("all", backs[1], {"1.cards": (1, 1), "2.cards": (1, 1)}),
        ("all", backs[1], {"1.cards": (1, 1), "2.cards": (1, 1)}),
    )
    for k, (control, (one, other), start) in enumerate(ways):

        def draw(one: Place = one, other: Place = other) -> Draw:
            people = [Person("RightCF", 0.7, 0.0), Person("LeftCB", *one), Person("LeftLB", *other)]
            return Draw(rules(rng), (0.0, 0.0), [*people, *keepers(rng), *crowd(rng, "Right", 2, (0.0, 0.0), 8.0)])

        both = (control, "2" if control == "2" else "none")
        yield scene(rng, f"cards {k}", draw, SLIDES, both, start=start, steps=2 * STEPS)


def keepers_feet(rng: Rng) -> Iterator[Scene]:
    """Yield balls that teammates play back to their keepers."""
    for k, team in enumerate(("Left", "Right")):
        side = -1.0 if team == "Left" else 1.0

        def draw(side: float = side, team: str = team) -> Draw:
            people = [Person(f"{team}CB", 38.0 * side, 0.0), Person(f"{team}GK", 51.0 * side, 0.5)]
            others = [team, "Right" if team == "Left" else "Left"]
            people += [person for other in others for person in crowd(rng, other, 2, (30.0 * side, 0.0), 8.0)]
            return Draw(rules(rng), (40.0 * side, 0.0), people)

        mate = 1 if team == "Left" else 3
        start = {
            "ball.vx": (6.0 * side, 16.0 * side),
            "was_kicked": (1, 1),
            "last_touch": (mate, mate),
            "kick_age": (0.1, 0.1),
        }
        yield scene(rng, f"back {k}", draw, PASSES, ("closest1", "none"), start=start, scripted=k == 0)


def flights(rng: Rng) -> Iterator[Scene]:
    """Yield balls that fly or roll at players, from the wing or along the middle: first touches, headers, blocks."""
    controls = (("closest1", "none"), ("all", "none"), ("active", "active"))
    for k in range(8):
        x, y = (44.0, 0.0) if k % 2 else rng.uniform((-30, -20), (30, 20)).tolist()

        def draw(x: float = x, y: float = y, k: int = k) -> Draw:
            people = crowd(rng, "Left", 2 + k % 3, (x, y), 4.0) + crowd(rng, "Right", 1 + k % 4, (x, y), 4.0)
            return Draw(rules(rng), (x - 13.0, y + (13.0 if k % 4 else 0.0)), [*people, *keepers(rng)])

        across = (-16.0, -8.0) if k % 4 else (-1.5, 1.5)
        start = {"ball.vx": (9.0, 20.0), "ball.vy": across, "ball.vz": (0.0, 9.0) if k % 3 else (0.0, 2.0)}
        start |= {"ball.z": (0.11, 1.0), "ball.curl": (-2.0, 2.0)}
        yield scene(rng, f"flight {k}", draw, SHOOTS, controls[k % 3], start=start)


def shots(rng: Rng) -> Iterator[Scene]:
    """Yield shots on their way to the goal: low and high, from near and far, past backs or at the keeper alone."""
    for k in range(4):
        away = (9.0, 15.0, 22.0, 30.0)[k]

        def draw(away: float = away, k: int = k) -> Draw:
            x = 55.0 - away
            people = [Person("LeftCF", x - 2.0, 1.0), Person("RightGK", 53.0 - k, 0.5)]
            people += crowd(rng, "Left", 1, (49.0, 4.0), 3.0) + crowd(rng, "Right", k, (x + 6.0, 1.0), 4.0)
            return Draw(rules(rng), (x, 1.0), people)

        start = {"ball.vx": (14.0, 32.0), "ball.vy": (-60.0 / away, 50.0 / away), "ball.vz": (0.0, 8.0)}
        yield scene(rng, f"shot {k}", draw, SHOOTS, ("closest1", "none"), start=start, scripted=k % 2 == 1)


def restarts(rng: Rng) -> Iterator[Scene]:
    """Yield each kind of restart, by built-in players and by agents, for both teams."""
    kinds = (  # with the number of players a side
        *((CORNER, 55.0, 36.0, LEFT, 11), (CORNER, -55.0, -36.0, RIGHT, 8), (FREE_KICK, 34.0, 4.0, LEFT, 11)),
        *((FREE_KICK, -36.0, -6.0, RIGHT, 6), (FREE_KICK, -5.0, 20.0, LEFT, 11), (GOAL_KICK, -50.6, 0.0, LEFT, 6)),
        *((GOAL_KICK, 50.6, 0.0, RIGHT, 11), (THROW_IN, 20.0, 36.0, LEFT, 11), (THROW_IN, -40.0, -36.0, RIGHT, 11)),
        *((PENALTY, 44.0, 0.0, LEFT, 3), (PENALTY, -44.0, 0.0, RIGHT, 5), (PENALTY, 44.0, 0.0, LEFT, 11)),
    )
    for k, (mode, x, y, team, count) in enumerate(kinds):

        def draw(x: float = x, y: float = y, count: int = count) -> Draw:
            people = eleven("Left", x / 3, count) + eleven("Right", x / 3, count)
            return Draw(rules(rng), (x, y), people)

        start = {"ball.x": (x, x), "ball.y": (y, y), "game_mode": (mode, mode), "restart_team": (team, team)}
        control = ("closest1", "none") if team == LEFT else ("none", "closest1")
        yield scene(rng, f"restart {k}", draw, PASSES, control, start=start, scripted=k % 2 == 0)


def behaviors(rng: Rng) -> Iterator[Scene]:
    """Yield players with behaviors of the library."""
    controls = (("none", "1"), ("closest1", "none"), ("1", "1"), ("active", "none"))
    for k, control in enumerate(controls):

        def draw(k: int = k) -> Draw:
            x, y = float(rng.uniform(-10, 35)), float(rng.normal(0, 10))
            others = [*crowd(rng, "Left", 2 + k, (x + 5, y), 8.0), *crowd(rng, "Right", 2, (x + 5, y), 8.0)]
            people = [person._replace(behavior=str(rng.choice(BEHAVIORS))) for person in others]
            first = Person("LeftCF", x - 1.2, y, BEHAVIORS[-1 if k == 2 else k])
            return Draw(rules(rng, agents_only=k == 3), (x, y), [first, *people, keeper(rng, "Right")], SEVERAL)

        yield scene(rng, f"behaviors {k}", draw, LETTERS, control, scripted=k == 2)


def engines(rng: Rng) -> Iterator[Scene]:
    """Yield matches with other factors, other endings, without the magnet."""
    factors = {"reaction_time": 1.3, "start_lag": 0.8, "keeper_speed": 1.2, "keeper_range": 0.7, "keeper_reach": 1.2}
    endings = ("end_episode_on_score", "end_episode_on_out_of_play", "end_episode_on_possession_change")
    ends = [{name: name == end for name in endings} for end in endings]
    ways: tuple[dict[str, Any], ...] = (
        {"sticky_noise": 0.3},
        {"use_magnet": False},
        {"deterministic": True, "game_duration": 45},
        {**factors, "tackle_odds": 0.7, "kick_spread": 1.5},
        *({**end, "defending": k == 2} for k, end in enumerate(ends)),
    )
    for k, way in enumerate(ways):

        def draw(way: dict[str, Any] = way) -> Draw:
            x, y = float(rng.uniform(0, 40)), float(rng.normal(0, 8))
            people = [Person("LeftCF", x - 1.2, y), *keepers(rng)]
            people += crowd(rng, "Left", 3, (x, y), 9.0) + crowd(rng, "Right", 3, (x + 8, y), 7.0)
            return Draw({**rules(rng), **way}, (x, y), people)

        start = (
            {"ball.x": (50.0, 53.0), "ball.y": (-3.0, 3.0), "ball.vx": (20.0, 30.0)}
            if way.get("end_episode_on_score")
            else {}
        )
        yield scene(rng, f"engine {k}", draw, SHOOTS, start=start, engine_spread=0.25 if k in (0, 3) else 0.0)


def struck(rng: Rng) -> Iterator[Scene]:
    """Yield balls struck a moment ago at nearby opponents, about as high as these reach."""
    ways = (  # m to the first opponent, m/s and m of the ball, s since the kick
        (0.8, {"ball.vx": (8.0, 14.0), "ball.vz": (-1.0, 4.0), "ball.z": (1.6, 2.2)}, (0.0, 0.05)),
        (1.2, {"ball.vx": (12.0, 16.0), "ball.vz": (0.3, 0.8), "ball.z": (1.88, 2.02)}, (0.0, 0.02)),
    )
    for k, (away, ball, age) in enumerate(ways):

        def draw(away: float = away) -> Draw:
            people = [Person("LeftCF", -0.6, 0.0), Person("RightCB", away, 0.1), Person("RightLB", away + 0.7, -0.3)]
            return Draw(rules(rng), (0.0, 0.0), [*people, *keepers(rng)])

        # the striker is player 1: keepers come first
        start = {**ball, "was_kicked": (1, 1), "last_touch": (1, 1), "kick_age": age}
        for part in range(2):
            yield scene(rng, f"struck {2 * k + part}", draw, SHOOTS, start=start, spread=0.15)


FAMILIES = (
    matches,
    open_play,
    attacks,
    lines,
    duels,
    runs,
    cards,
    keepers_feet,
    flights,
    shots,
    restarts,
    behaviors,
    engines,
    struck,
)


def draw_scenes(seed: int) -> Iterator[Scene]:
    """Draw all scenes, with more rows than the file keeps."""
    for k, family in enumerate(FAMILIES):
        yield from family(np.random.default_rng([seed, k]))
