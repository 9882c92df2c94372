"""The football world that behaviors see: units, headings, the right team's view, the actions that are none."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pitch import position, take_over

from regista.envs.football.constants import (
    BUILTIN_AI,
    CM,
    GK,
    LEFT,
    METRES_PER_X,
    METRES_PER_Y,
    NOBODY,
    RIGHT,
    SHOT,
)
from regista.envs.football.scenic.domain import FOOTBALL
from regista.envs.football.scenic.lineup import Lineup
from regista.envs.football.scenic.scripted_step import command_players
from regista.envs.football.scenic.world import FOOTBALL_WORLD
from regista.envs.football.scenic.world_fields import FACTS, FIELDS
from regista.envs.football.scenic.world_table import NUM_FIELDS, THE_BALL, heading, in_team_frame, write_world
from scenic_lite import ScenicError, load
from scenic_lite.core.types import Instance, ScenicClass
from scenic_lite.core.world import packed
from scenic_lite.values.geometry import Vector

NORTH, WEST, SOUTH, EAST = 0.0, math.pi / 2, math.pi, 3 * math.pi / 2
CAST = np.array([1, THE_BALL, 0])  # a program of a right player, the ball and a left player
THREE = [(-10.88, 8.36, LEFT, CM), (27.2, -16.72, RIGHT, GK)]


def tables(matches: np.ndarray) -> tuple[list[dict[str, float]], dict[str, float]]:
    """Return the table of each object and the facts, by name."""
    row = np.full(7 + len(CAST) * NUM_FIELDS + len(FACTS), np.nan)
    write_world(matches[0], CAST, row, 7)
    assert np.isnan(row[:7]).all() and not np.isnan(row[7:]).any()
    cells = row[7 : 7 + len(CAST) * NUM_FIELDS].reshape(len(CAST), NUM_FIELDS)
    facts = row[7 + len(CAST) * NUM_FIELDS :]
    return [dict(zip(FIELDS, cell, strict=True)) for cell in cells], dict(zip(FACTS, facts, strict=True))


def test_places_are_in_the_units_of_programs() -> None:
    objects, facts = tables(position(THREE, (54.4, 0.0)))
    assert [(round(each["x"], 9), round(each["y"], 9)) for each in objects] == [(50, -20), (100, 0), (-20, 10)]
    assert facts == {"time": 0, "steps_left": 400, "score_left": 0, "score_right": 0, "game_mode": 0, "done": 0}


def test_everybody_looks_at_the_ball_and_headings_grow_anticlockwise() -> None:
    matches = position([(-10.88, 0.0, LEFT, CM), (27.2, 0.0, RIGHT, GK)], (0.0, 0.0))
    matches["ball"]["vy"] = -8.36
    objects, _ = tables(matches)
    assert [each["heading"] for each in objects] == pytest.approx([WEST, SOUTH, EAST])
    assert (objects[1]["vx"], objects[1]["vy"], objects[1]["speed"]) == pytest.approx((0, -10, 10))


@pytest.mark.parametrize(
    ("x", "y", "expected"),
    [(0, 0, NORTH), (0, 2, NORTH), (-1, 0, WEST), (0, -3, SOUTH), (4, 0, EAST), (1, 1, 7 * math.pi / 4)],
)
def test_headings(x: float, y: float, expected: float) -> None:
    assert heading(float(x), float(y)) == pytest.approx(expected)


def test_a_heading_is_the_angle_that_a_program_measures() -> None:
    """The pitch has other units along x than along y: someone who looks along 45 degrees in meters does not here."""
    matches = position([(0.0, 0.0, LEFT, CM), (27.2, -16.72, RIGHT, GK)], (0.0, 0.0))
    matches["players"]["facing_x"][0, 0] = matches["players"]["facing_y"][0, 0] = math.sqrt(0.5)
    objects, _ = tables(matches)
    ahead = Vector(1 / METRES_PER_X, 1 / METRES_PER_Y)
    assert objects[2]["heading"] == pytest.approx(math.atan2(-ahead.x, ahead.y) % (2 * math.pi))


def test_who_owns_the_ball_is_known_of_the_player_and_of_the_ball() -> None:
    matches = position(THREE, (0.0, 0.0))
    matches["reported_owner"] = 1
    objects, _ = tables(matches)
    assert [each["owns_ball"] for each in objects] == [1, 0, 0]
    assert (objects[1]["owned_team"], objects[1]["owned_player_idx"]) == (RIGHT, 0)
    matches["reported_owner"] = -1
    objects, _ = tables(matches)
    assert (objects[1]["owned_team"], objects[1]["owned_player_idx"]) == (-1, -1)


def test_the_right_team_sees_the_pitch_from_the_other_end() -> None:
    assert [in_team_frame(RIGHT, action) for action in range(20)] == [0, 5, 6, 7, 8, 1, 2, 3, 4, *range(9, 20)]
    assert [in_team_frame(LEFT, action) for action in range(20)] == list(range(20))
    assert all(in_team_frame(RIGHT, in_team_frame(RIGHT, action)) == action for action in range(20))
    matches = position(THREE, (0.0, 0.0))
    matches["players"]["direction"] = 4
    objects, _ = tables(matches)
    assert (objects[0]["pressed"], objects[2]["pressed"]) == (8, 4)


# ---------------------------------------------------------------- actions


def commanded(commands: list[float]) -> list[int]:
    matches = position(THREE, (0.0, 0.0))
    matches["players"]["action"] = BUILTIN_AI
    take_over(matches, NOBODY)
    command_players(matches[0], CAST, np.array(commands))
    return matches["players"]["action"][0, :2].tolist()


@pytest.mark.parametrize(
    ("commands", "left", "right"),
    [
        ([-1.0, -1.0, -1.0], BUILTIN_AI, BUILTIN_AI),
        ([5.0, 3.0, 5.0], 5, 1),  # each towards the goal that he attacks
        ([SHOT, -1.0, 0.0], 0, SHOT),
        ([19.0, -1.0, 18.0], 18, 19),
        ([packed((5, 13), 20), -1.0, packed((13, 2, 12), 20)], packed((13, 2, 12), 20), packed((1, 13), 20)),
        ([packed((5, 19), 20), -1.0, packed((19, 5), 20)], BUILTIN_AI, BUILTIN_AI),
        ([packed((0, 5), 20), -1.0, packed((0, 0), 20)], 0, 1),
    ],
)
def test_commands_reach_the_players(commands: list[float], left: int, right: int) -> None:
    assert commanded(commands) == [left, right]


def test_whom_the_learner_moves_does_not_obey_his_behavior() -> None:
    matches = position(THREE, (0.0, 0.0))
    matches["players"]["action"] = 7
    take_over(matches, 0)
    command_players(matches[0], CAST, np.array([2.0, -1.0, 2.0]))
    assert matches["players"]["action"][0, :2].tolist() == [7, 6]


PLAYER = Instance(ScenicClass("Player", None), None, properties={})
BALL = Instance(ScenicClass("Ball", None), None, name="ball", properties={})


@pytest.mark.parametrize(
    ("value", "who", "message"),
    [
        (20, PLAYER, "there is no action 20; actions are 0 to 19"),
        (-1, PLAYER, "there is no action -1; actions are 0 to 19"),
        (2.5, PLAYER, "there is no action 2.5; actions are 0 to 19"),
        (math.nan, PLAYER, "there is no action nan; actions are 0 to 19"),
        ("shoot", PLAYER, "an action of football is a number, not a text"),
        (True, PLAYER, "an action of football is a number, not a truth value"),
        (None, PLAYER, "an action of football is a number, not None"),
        (5, BALL, "ball is a ball; only players take actions"),
    ],
)
def test_what_is_no_action_is_refused(value: object, who: Instance, message: str) -> None:
    with pytest.raises(ScenicError) as error:
        FOOTBALL_WORLD.command(value, who)
    assert error.value.message == message


def test_the_lineup_finds_each_objects_player() -> None:
    program = load("ego = RightCM at 0 @ 0\nball = Ball at 5 @ 5\nLeftCB at 9 @ 9\nLeftGK at -99 @ 0\n", FOOTBALL)
    assert Lineup(program).object_to_player.tolist() == [2, THE_BALL, 1, 0]


def test_the_state_of_the_game_has_the_names_that_programs_use() -> None:
    def instance(name: str, team: str | None = None) -> Instance:
        kind = ScenicClass("Player" if team else "Ball", None)
        return Instance(kind, None, name=name, properties={"team": team} if team else {})

    objects = [instance("a", "left"), instance("ball"), instance("b", "right"), instance("c", "left")]
    facts = {name: float(number) for number, name in enumerate(FACTS)}
    seen = FOOTBALL_WORLD.simulation(objects, facts).names
    assert (seen["currentTime"], seen["timestep"]) == (0, 0.1)
    game = seen["game_ds"].names
    names = {key: [each.name for each in game[key]] for key in ("players", "left_players", "right_players")}
    assert names == {"players": ["a", "b", "c"], "left_players": ["a", "c"], "right_players": ["b"]}
    assert game["ball"].name == "ball" and game["score"] == [2, 3] and game["game_state"].names["steps_left"] == 1
