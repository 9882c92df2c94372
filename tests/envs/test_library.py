"""The questions that football's library answers, asked of hand-made scenes; and what its behaviors press."""

from __future__ import annotations

import math

import numpy as np
import pytest

from regista.envs.football.scenic.domain import FOOTBALL, LIBRARY, MODULES
from regista.envs.football.scenic.world import FOOTBALL_WORLD
from regista.envs.football.scenic.world_fields import FACTS, FIELDS
from scenic_lite import load
from scenic_lite.dynamics.compiler.compile import compile_program
from scenic_lite.dynamics.machine.bytecode import FAULT, FAULT_ROW, PROGRAM_ERROR
from scenic_lite.errors import ScenicError
from tests.reference.interpreter import Reference

HEAD = """
from football.behaviors import *

behavior Ask():
    while True:
        take {question}

{scene}
ball = Ball at 0 @ 41
"""
BEHAVIORS = "from football.behaviors import *\n"
NOBODY = {"owned_team": -1.0, "owned_player_idx": -1.0}


class Scene:
    """A program in a world that stands still but for what a test changes: rows of the world table by object."""

    def __init__(self, text: str, seed: int = 0) -> None:
        program = load(text, FOOTBALL)
        scenes = program.instantiate(np.zeros((1, program.dim)))
        self.names = [info.name for info in program.objects]
        self.table = np.zeros((len(self.names), len(FIELDS)))
        self.table[:, :2], self.table[:, 2] = scenes.positions[0], scenes.headings[0]
        for field, value in NOBODY.items():
            self.table[:, FIELDS.index(field)] = value
        self.facts = np.zeros(len(FACTS))
        self.reference = Reference(program, np.zeros(program.dim), FOOTBALL_WORLD, seed)

    def set(self, name: str, **fields: float) -> Scene:
        for field, value in fields.items():
            self.table[self.names.index(name), FIELDS.index(field)] = value
        return self

    def step(self) -> dict[str, float | None]:
        """Return what each named object presses in one step."""
        commands = self.reference.act(self.table, self.facts)
        assert not commands.terminated and not commands.rejected
        self.facts[0] += 1
        return {name: row[0] if row else None for name, row in zip(self.names, commands.actions, strict=True) if name}

    def presses(self, name: str, steps: int) -> list[float | None]:
        return [self.step()[name] for _ in range(steps)]


def answer(question: str, scene: str) -> float | None:
    return Scene(HEAD.format(question=question, scene=scene)).step()["ego"]


ALONE = "ego = LeftCM at 0 @ 0, facing {heading}, with behavior Ask()\n"
EAST = ALONE.format(heading="east")


@pytest.mark.parametrize(("heading", "left", "right"), [("north", 3, 7), ("west", 1, 5), ("southeast", 6, 2)])
def test_the_current_direction_is_as_the_player_sees_the_pitch(heading: str, left: int, right: int) -> None:
    scene = ALONE.format(heading=heading)
    assert answer("currentDirectionIndex(self)", scene) == left
    assert answer("currentDirectionIndex(self)", scene.replace("LeftCM", "RightCM")) == right


@pytest.mark.parametrize(
    ("dx", "dy", "direction"),
    [
        (-9, 0, 1),
        (-9, 9, 2),
        (0, 9, 3),
        (9, 9, 4),
        (9, 0, 5),
        (9, -9, 6),
        (0, -9, 7),
        (-9, -9, 8),
        (-9, 3, 1),
        (9, 4, 4),
    ],
)
def test_directions_are_sectors_of_45_degrees(dx: int, dy: int, direction: int) -> None:
    assert answer(f"lookup_direction({dx}, {dy})", EAST) == direction


def test_a_right_player_is_led_towards_a_point_by_his_own_view() -> None:
    scene = EAST.replace("LeftCM", "RightCM")
    assert answer("MoveTowardsPoint(-9 @ 0, self.position, True)", scene) == 5
    assert answer("MoveTowardsPoint(-9 @ 0, self.position)", scene) == 1


@pytest.mark.parametrize(
    ("place", "side"),
    [("5 @ 3", "left"), ("5 @ -3", "right"), ("-5 @ 3", "none")],
)
def test_the_side_of_the_nearest_opponent_goes_by_the_heading(place: str, side: str) -> None:
    question = '["left", "right", "none"].index(nearestOpponentRelativePositionAhead(self))'
    assert answer(question, f"{EAST}RightCB at {place}\n") == ["left", "right", "none"].index(side)


def test_nobody_is_nobody() -> None:
    assert answer("1 if nearestOpponent(self) is None else 0", EAST) == 1
    assert answer("1 if nearestTeammate(self) is None else 0", EAST) == 1
    assert answer('1 if nearestOpponentRelativePositionAhead(self) == "none" else 0', EAST) == 1
    assert answer("1 if aimPointToShoot(self) is None else 0", EAST) == 0  # both corners are open


def test_the_nearest_players_leave_out_oneself() -> None:
    scene = EAST + "near = LeftCB at 5 @ 5\nLeftGK at -99 @ 0\nkeeper = RightGK at 8 @ 0\nRightCB at 20 @ 0\n"
    assert answer("1 if nearestTeammate(self) is near else 0", scene) == 1
    assert answer("1 if nearestOpponent(self) is keeper else 0", scene) == 1
    assert answer("get_closest_player_info(self, simulation().game_ds.right_players)[1]", scene) == 8
    of_a_place = "get_closest_player_info(self.position, simulation().game_ds.left_players)[0]"
    assert answer(f"1 if {of_a_place} is near else 0", scene) == 1


@pytest.mark.slow
@pytest.mark.parametrize(("place", "inside"), [("4 @ 0", 1), ("3 @ 2.9", 1), ("2 @ 3", 0), ("6 @ 0", 0), ("-3 @ 0", 0)])
def test_the_runway_is_a_quarter_disc_ahead(place: str, inside: int) -> None:
    assert answer("1 if opponentInRunway(self) else 0", f"{EAST}RightCB at {place}\n") == inside
    assert answer("1 if opponentInRunway(self) else 0", f"{EAST}LeftCB at {place}\n") == 0


def test_possession_is_the_teams() -> None:
    text = HEAD.format(
        question="(1 if teammateHasBallPossession(self) else 0) + (2 if opponentTeamHasBallPossession(self) else 0)",
        scene=EAST + "mate = LeftCB at 5 @ 5\nopponent = RightCB at 9 @ 9\n",
    )
    assert Scene(text).step()["ego"] == 0
    assert Scene(text).set("ego", owns_ball=1).step()["ego"] == 1
    assert Scene(text).set("mate", owns_ball=1).step()["ego"] == 1
    assert Scene(text).set("opponent", owns_ball=1).step()["ego"] == 2


def test_player_with_ball_may_ask_for_a_team() -> None:
    ask = "1 if player_with_ball(simulation().game_ds, ball, {team}) is {who} else 0"
    scene = EAST + "opponent = RightCB at 9 @ 9\n"
    teams = {"None": "opponent", '"right"': "opponent", "1": "opponent", '"left"': "None", "0": "None"}
    for team, who in teams.items():
        text = HEAD.format(question=ask.format(team=team, who=who), scene=scene)
        assert Scene(text).set("opponent", owns_ball=1).step()["ego"] == 1


def test_the_owner_of_the_ball_is_an_index_of_his_team() -> None:
    """In a match that is compiled, too: the compiler takes no index but one that it knows to be an integer."""
    text = HEAD.format(
        question="simulation().game_ds.my_players[ball.owned_player_idx].x if ball.owned_team == 0 else 9",
        scene=EAST + "mate = LeftCB at 5 @ 5\n",
    )
    assert Scene(text).step()["ego"] == 9
    assert Scene(text).set("ball", owned_team=0, owned_player_idx=1).step()["ego"] == 5
    assert not compile_program(load(text, FOOTBALL), FOOTBALL_WORLD).diagnostics


def test_a_direction_that_is_pressed_is_not_pressed_again() -> None:
    text = HEAD.format(question="set_dir_if_not(SetDirection(5), self.sticky_actions)", scene=EAST)
    assert Scene(text).step()["ego"] == 5
    assert Scene(text).set("ego", pressed=5).step()["ego"] == 0
    shot = HEAD.format(question="set_dir_if_not(Shoot(), self.sticky_actions)", scene=EAST)
    assert Scene(shot).set("ego", pressed=5).step()["ego"] == 12


@pytest.mark.parametrize(("keeper", "corner"), [("95 @ 3", "right"), ("95 @ -3", "left"), ("62 @ 0", "none")])
def test_shots_are_aimed_at_an_open_corner(keeper: str, corner: str) -> None:
    """A narrow lane: the keeper near one corner leaves the other open; one who stands right ahead covers both."""
    scene = f"ego = LeftCM at 60 @ 0, facing east, with behavior Ask()\nRightGK at {keeper}\n"
    question = "0 if aimPointToShoot(self, 4 deg) is None else 10 + aimPointToShoot(self, 4 deg).y"
    if corner == "none":
        question = question.replace("4 deg", "20 deg")
    assert answer(question, scene) == {"left": 13, "right": 7, "none": 0}[corner]


# ---------------------------------------------------------------- behaviors


def behaving(behavior: str, who: str = "LeftCM at 0 @ 0", more: str = "") -> Scene:
    return Scene(f"{BEHAVIORS}ball = Ball at 0 @ 41\nego = {who}, with behavior {behavior}\n{more}\n")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("behavior", "who", "presses"),
    [
        ("HoldPosition()", "LeftCM at 0 @ 0", [15, 14, 15, 14]),
        ("IdleBehavior()", "LeftCM at 0 @ 0", [0, 0, 0]),
        ("BuiltinAIBot()", "LeftCM at 0 @ 0", [19, 19]),
        ("RunRight()", "RightCM at 0 @ 0", [5, 5]),
        ("MoveToPosition(9 @ 0)", "LeftCM at 0 @ 0", [5, 5, 5]),
        ("MoveToPosition(9 @ 0)", "RightCM at 0 @ 0", [1, 1, 1]),
        ("MoveToPosition(1 @ 0)", "LeftCM at 0 @ 0", [14, None, None]),
        ("MoveToPosition(12 @ 0, sprint=True)", "LeftCM at 0 @ 0", [5, 13, 5, 13]),
        ("MoveToPosition(9 @ 0, sprint=True)", "LeftCM at 0 @ 0", [15, 14, None]),
        ("ShortPassTo(ball)", "LeftCM at 0 @ 0", [3, 11, 15, 14, None]),
        ("HighPassTo(ball)", "RightCM at 0 @ 0", [7, 10, 15, 14, None]),
        ("LongPassTo(ball)", "LeftCM at 0 @ 0", [3, 9, 15, 14, None]),
        ("FollowObject(ball)", "LeftCM at 0 @ 0", [3, 3]),
        ("FollowObject(ball, terminate_distance=50)", "LeftCM at 0 @ 0", [14, None]),
        ("PassToPoint(9, 0)", "LeftCM at 0 @ 0", [0, None]),
        ("AimGoalCornerAndShoot()", "LeftCM at 98 @ 30", [15, 14, 7, 12, 15, 14, None]),
        ("AimGoalCornerAndShoot()", "RightCM at -98 @ 30", [15, 14, 3, 12, 15, 14, None]),
        ("dribbleToAndShoot(80 @ 0)", "LeftCM at 75 @ 0", [15, 14, 5, 12, 15, 14, 15]),
        ("dribbleToAndShoot(-80 @ 0)", "RightCM at -75 @ 0", [15, 14, 5, 12, 15, 14, 15]),
        ("dribbleToAndShoot(40 @ 0)", "LeftCM at 0 @ 0", [5, 5, 5]),
        ("dribbleToAndShoot(40 @ 0, sprint=True)", "LeftCM at 0 @ 0", [5, 13, 5]),
    ],
)
def test_what_a_behavior_presses(behavior: str, who: str, presses: list[float | None]) -> None:
    assert behaving(behavior, who).presses("ego", len(presses)) == presses


@pytest.mark.parametrize(("kind", "kick"), [("long", 9), ("high", 10), ("short", 11), ("shoot", 12)])
def test_a_pass_to_a_point_is_turned_for_right_players(kind: str, kick: int) -> None:
    for who, direction in (("LeftCM at 0 @ 0", 5), ("RightCM at 0 @ 0", 1)):
        scene = behaving(f'PassToPoint(9, 0, "{kind}")', who).set("ego", owns_ball=1)
        assert scene.presses("ego", 4) == [direction, kick, direction, kick]
        assert scene.set("ego", owns_ball=0).presses("ego", 2) == [None, None]


def test_the_zigzag_evades_to_the_other_side_and_stays_on_the_pitch() -> None:
    """Running east near the upper line, an opponent ahead on the right: round him on the left, not over the line."""
    scene = behaving("dribble_evasive_zigzag(60 @ 30)", "LeftCM at 0 @ 36, facing east", "RightCB at 4 @ 34")
    assert scene.presses("ego", 2) == [4, 4]
    scene.set("ego", x=8.0, y=39.5)
    presses = scene.presses("ego", 4)
    assert presses[0] in (5, 14)
    assert behaving("dribble_evasive_zigzag(60 @ 0)", "LeftCM at 0 @ 0, facing east").presses("ego", 2) == [5, 13]


def test_dribbling_is_interrupted_by_an_opponent_on_the_runway() -> None:
    scene = behaving("dribbleToAndShoot(60 @ 0)", "LeftCM at 0 @ 0, facing east", "wall = RightCB at 60 @ -1")
    assert scene.presses("ego", 2) == [5, 5]
    scene.set("wall", x=8.0)
    assert scene.presses("ego", 2) == [4, 4]  # round him on the left


# ---------------------------------------------------------------- imports


@pytest.mark.parametrize("name", sorted(FOOTBALL.library))
def test_every_name_can_be_imported(name: str) -> None:
    program = load(
        f"from {name} import *\nego = LeftCM at 0 @ 0\nBall at 5 @ 5\n"
        if "model" in name
        else f"from football.model import *\nfrom {name} import *\nego = LeftCM at 0 @ 0\nBall at 5 @ 5\n",
        FOOTBALL,
    )
    assert len(program.objects) == 2
    found = {path.name for path in LIBRARY.glob("*.scenic")}
    assert found == {path.name for path in MODULES.values()} | {"football.scenic"}


def test_imports_of_scenic4rls_own_library_mean_something() -> None:
    program = load(
        "from scenic.simulators.gfootball import model\nfrom scenic.simulators.gfootball.behaviors import *\n"
        "from scenic.core.regions import regionFromShapelyObject, SectorRegion\n"
        "from scenic.simulators.gfootball.utilities.constants import ActionCode\n"
        "ego = LeftCM in model.right_penaltyBox\nBall at 5 @ 5\nparam right = ActionCode.right\n",
        FOOTBALL,
    )
    assert program.params["right"] == 5


def test_compass_directions_are_headings() -> None:
    names = ["north", "northwest", "west", "southwest", "south", "southeast", "east", "northeast"]
    text = "from football.model import *\nego = LeftCM at 0 @ 0\nBall at 5 @ 5\n"
    program = load(text + "".join(f"param {name}_ = {name}\n" for name in names), FOOTBALL)
    for index, name in enumerate(names):
        assert program.params[f"{name}_"] == pytest.approx(index * math.pi / 4)


def test_a_fault_inside_a_function_is_told_where_the_program_calls_it() -> None:
    owner = "player_with_ball(simulation().game_ds, ball)"
    text = HEAD.format(question=f"round(get_closest_player_info({owner}, [ego])[1])", scene=EAST)
    compiled = compile_program(load(text, FOOTBALL), FOOTBALL_WORLD)
    rows = [row for row, note in compiled.listing.notes.items() if note.startswith("None is not an object")]
    registers = compiled.start.copy()
    registers[[FAULT, FAULT_ROW]] = PROGRAM_ERROR, rows[0]
    told = compiled.fault(registers)
    with pytest.raises(ScenicError) as error:
        Scene(text).step()
    assert told is not None and told.place == error.value.place
    assert told.place.file == "<program>" and told.place.line == 6
    assert "\n    in football/actions.scenic:" in str(told) and "distance from player to other" in str(told)
