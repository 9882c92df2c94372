"""The built-in AI: slots, markers, hunters, runs, passes and shots, from hand-made positions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from pitch import OPEN, play, position, take_over

from regista.envs.football.ai.attack import push_of_rivals
from regista.envs.football.ai.decide import choose_command
from regista.envs.football.ai.defence import RACE, goes_for_led_ball, guarding_place, set_defensive_lines
from regista.envs.football.ai.formation import formation_slots
from regista.envs.football.ai.positions import take_position
from regista.envs.football.config import FootballConfig
from regista.envs.football.constants import (
    CB,
    CF,
    CM,
    DIRECTION_BOTTOM_RIGHT,
    DIRECTION_RIGHT,
    GK,
    HIGH_PASS,
    IDLE,
    LB,
    LEFT,
    LONG_PASS,
    NOBODY,
    POSSESSION,
    RB,
    RIGHT,
    SHORT_PASS,
    SHOT,
    SPRINT,
)
from regista.envs.football.kick_off import MatchConfig
from regista.envs.football.physics.possession import look_ahead, meeting_time
from regista.envs.football.vector_env import FootballVectorEnv

KEEPERS = [(-54.0, 0.0, LEFT, GK), (54.0, 0.0, RIGHT, GK)]
FOUR = [(-20.0, -8.0, LEFT, CB), (-20.0, 8.0, LEFT, CB), (-8.0, 0.0, LEFT, CM), (-2.0, 3.0, LEFT, CF)]
THEIRS = [(20.0, -8.0, RIGHT, CB), (20.0, 8.0, RIGHT, CB), (8.0, 0.0, RIGHT, CM), (2.0, -13.0, RIGHT, CF)]


def alone(players: list, ball: tuple[float, float], n: int = 40, **settings: object) -> np.ndarray:
    """Return matches of built-in players only."""
    matches = position(players, ball, replace(OPEN, **settings), range(n))
    take_over(matches, NOBODY)
    return matches


def test_slots_belong_to_numbers_and_keep_their_distance() -> None:
    slots = formation_slots(11)
    assert slots[0].tolist() == [-1.0, 0.0]
    assert slots[1:5, 0].max() < slots[5:8, 0].min() < slots[9, 0] == 1.0
    assert slots[1, 1] > 0.7 and np.allclose(slots[1, 1], -slots[4, 1], atol=0.05)
    between = np.linalg.norm(slots[1:, None] - slots[None, 1:], axis=-1)
    assert between[~np.eye(10, dtype=bool)].min() > 0.4


def test_players_run_to_their_numbers_slots_wherever_the_scene_puts_them() -> None:
    """Measured: a lone number 1, who has the left back's slot, drifts to his left while the carrier waits."""
    players = [(-55.0, 0.0, LEFT, GK), (13.2, 9.3, LEFT, CB), (55.0, 0.0, RIGHT, GK), (22.0, 5.6, RIGHT, CB)]
    matches = position(players, (14.1, 9.2), OPEN, range(20))
    play(matches, [0] * 30, player=1)
    place = matches["players"][:, 3]
    assert np.all(np.abs(place["x"] - 22.5) < 1.2) and np.all(np.abs(place["y"] + 4.0) < 1.2)


def test_one_of_two_backs_does_not_take_the_others_slot_where_only_both_together_gain() -> None:
    """Measured: who is behind the sprinter runs to his own slot, the other goes with him."""
    players = [(-55.0, 0.0, LEFT, GK), (10.9, 3.7, LEFT, CF), (55.0, 0.0, RIGHT, GK)]
    players += [(4.5, 4.7, RIGHT, LB), (9.8, 1.9, RIGHT, RB)]
    matches = position(players, (11.8, 3.7), OPEN, range(10))
    play(matches, [DIRECTION_RIGHT, SPRINT, *[DIRECTION_RIGHT] * 16], player=1)
    behind, beside = matches["players"][:, 3], matches["players"][:, 4]
    assert np.all(np.abs(behind["x"] - 9.0) < 2.0) and np.all(np.abs(behind["y"] + 3.7) < 2.0)
    assert np.all(np.abs(beside["x"] - 19.4) < 2.0) and np.all(np.abs(beside["y"] - 1.0) < 2.0)


def test_two_backs_exchange_their_slots_where_either_way_becomes_shorter_than_both_were() -> None:
    """Measured of these: the first keeps to y 3.6, the other to -4.3, though their slots are on the other sides."""
    players = [(-55.0, 0.0, LEFT, GK), (-10.5, 12.7, LEFT, CF), (55.0, 0.0, RIGHT, GK)]
    players += [(-12.0, 2.7, RIGHT, LB), (-10.0, -8.3, RIGHT, RB)]
    matches = position(players, (-9.6, 12.7), OPEN, range(10))
    play(matches, [DIRECTION_RIGHT, SPRINT, *[DIRECTION_RIGHT] * 22], player=1)
    assert np.all(np.abs(matches["players"]["y"][:, 3] - 3.6) < 1.5)
    assert np.all(np.abs(matches["players"]["y"][:, 4] + 4.3) < 1.5)


def test_the_block_follows_the_ball() -> None:
    means = []
    for ball_x in (-30.0, 30.0):
        matches = alone([*KEEPERS, *FOUR, *THEIRS], (ball_x, 0.0), game_duration=1000)
        play(matches, [0] * 60)
        means.append(matches["players"]["x"][:, 2:10].mean())
    assert means[1] - means[0] > 5.0


def test_the_most_dangerous_are_marked_and_at_most_two_hunt() -> None:
    matches = alone([*KEEPERS, *FOUR, *THEIRS], (-1.0, 3.0), game_duration=1000)
    marked = hunters = 0
    for _ in range(200):
        play(matches, [0])
        players = matches["players"]
        for team in (LEFT, RIGHT):
            marks = np.where(players["team"] == team, players["marked_opponent"], NOBODY)[:, :10]
            for row in marks:
                of = row[row != NOBODY]
                assert len(of) <= 3 and len(set(of)) == len(of)
                marked += len(of)
            hunters += np.count_nonzero(matches["hunter"][:, team] != NOBODY)
    assert marked > 0 and hunters > 0


@pytest.mark.parametrize("difficulty", [0.05, 1.0])
def test_a_lone_defender_gives_way_in_midfield(difficulty: float) -> None:
    """Measured: nobody loses the ball to a lone defender before he is some 25 m from the goal."""
    players = [(-50.0, 0.0, LEFT, GK), (0.0, 0.0, LEFT, CM), (12.0, 0.0, RIGHT, CB), (-50.0, 30.0, RIGHT, GK)]
    config = MatchConfig(right_team_difficulty=difficulty, end_episode_on_out_of_play=False)
    matches = position(players, (0.5, 0.0), config, range(20))
    for _ in range(35):
        play(matches, [5], player=1)
    assert np.all(matches["carrier"] == 1)
    assert np.all(matches["players"]["x"][:, 2] > matches["players"]["x"][:, 1] + 1.5)


def led_ball(away: float, stride: float = 0.0, team: int = RIGHT) -> np.ndarray:
    """Return a match: player 2 runs at 7 m/s after a ball 1.1 m ahead, which rolls towards player 3, `away` m on."""
    players = [*KEEPERS, (0.0, 0.0, team, CF), (-1.1 - away, 0.0, LEFT, CB), (-9.0, 9.0, RIGHT, CF)]
    matches = alone(players, (-1.1, 0.0), n=1)
    runner, ball = matches["players"][:, 2], matches["ball"]
    runner["vx"], runner["facing_x"], runner["facing_y"], runner["stride"] = -7.0, -1.0, 0.0, stride
    ball["vx"], matches["carrier"], matches["chaser"] = -8.0, 2, (3, 2)
    matches["players"]["marked_opponent"][:, 3] = 4  # another one, of whom he lets go
    return matches


@pytest.mark.parametrize(
    ("away", "stride", "team", "goes"),
    [
        (1.5, 0.0, RIGHT, True),
        (5.5, 0.0, RIGHT, True),
        (13.0, 0.0, RIGHT, False),
        (5.5, -0.05, RIGHT, False),
        (1.5, 0.0, LEFT, False),
    ],
    ids=["near", "sooner", "too far", "about to be played", "a mate's"],
)
def test_who_is_as_soon_at_a_led_ball_goes_for_it(away: float, stride: float, team: int, goes: bool) -> None:
    matches = led_ball(away, stride, team)
    assert bool(goes_for_led_ball(matches[0], 3)) == goes
    matches["chaser"][:, LEFT] = 0
    assert not goes_for_led_ball(matches[0], 3)  # not the first of his team


def test_nobody_races_for_a_ball_that_is_free_or_in_hands() -> None:
    free, held = led_ball(1.5), led_ball(1.5)
    free["carrier"], held["keeper_holding"] = NOBODY, 2
    assert not goes_for_led_ball(free[0], 3) and not goes_for_led_ball(held[0], 3)


@pytest.mark.parametrize(
    ("carrier", "back", "role", "key"),
    [
        ((-6.4, -24.6), (12.7, -26.5), LB, DIRECTION_RIGHT),
        ((4.3, -0.4), (23.0, -16.0), LB, DIRECTION_BOTTOM_RIGHT),
    ],
    ids=["ahead", "aside"],
)
def test_a_back_stops_before_a_sprinter_and_has_the_ball(
    carrier: tuple[float, float], back: tuple[float, float], role: int, key: int
) -> None:
    """Measured of either: 4 of 4 lose the ball within 35 steps, to a back who has come down to 2 to 4 m/s before."""
    players = [(-54.4, 0.0, LEFT, GK), (*carrier, LEFT, CF), (54.4, 0.0, RIGHT, GK), (*back, RIGHT, role)]
    matches = position(players, (carrier[0] + 1.0, carrier[1]), OPEN, range(40))
    lost, stopped = np.zeros(40, bool), np.zeros(40, bool)
    for pressed in [key, key, SPRINT, *[IDLE] * 37]:
        play(matches, [pressed], player=1)
        runner, guard = matches["players"][:, 1], matches["players"][:, 3]
        away = np.hypot(guard["x"] - runner["x"], guard["y"] - runner["y"])
        stopped |= ~lost & (away > 2.5) & (away < 6.0) & (np.hypot(guard["vx"], guard["vy"]) < 4.0)
        lost |= matches["reported_owner"] == 3
    assert lost.mean() > 0.6
    assert stopped.mean() > 0.8


@pytest.mark.parametrize(("in_time", "least", "most"), [(0.9, -10.0, 0.0), (1.05, 5.0, 10.0), (1.3, -0.1, 3.0)])
def test_a_guard_leaves_whom_he_marks_for_a_led_ball_and_lets_it_come(
    in_time: float, least: float, most: float
) -> None:
    """Later than the carrier he goes on guarding, as soon he runs at the ball, clearly sooner he waits for it."""
    matches = led_ball(4.0)
    ball = matches[0]["ball"]
    mine = meeting_time(ball, look_ahead(ball), matches[0]["players"][3])
    matches["players"]["stride"][:, 2] = RACE.patience - in_time * (mine + RACE.patience)
    choose_command(matches[0], 3)
    assert least <= matches["players"]["desired_vx"][0, 3] <= most


def test_a_guard_of_whom_is_past_the_line_goes_behind_his_back() -> None:
    """Measured: a lone back who marks a forward 8 m behind him runs to his own side, 8 m off the middle."""
    players = [(30.0, 0.0, LEFT, CM), (44.0, -8.0, LEFT, CF), (38.0, -4.0, RIGHT, CB), (54.0, 0.0, RIGHT, GK)]
    matches = alone(players, (30.4, 0.0), n=1)
    back = matches["players"][0, 2]
    matches["trap"][:, RIGHT], back["marked_opponent"] = -36.0, 1
    x, y = guarding_place(matches[0], matches[0].players[2], 36.0, -4.0)
    assert x < 38.0 and y < -7.0


@pytest.mark.parametrize(("run", "line"), [(-4.0, 9.48), (0.0, 10.0), (4.0, 10.52)])
def test_opponents_see_where_the_last_line_will_be(run: float, line: float) -> None:
    """As documented they lead its run by 0.24 s, but as it was a reaction time ago."""
    matches = alone([*KEEPERS, *FOUR, (10.0, 0.0, RIGHT, CB), (2.0, -13.0, RIGHT, CF)], (-20.0, 0.0), n=1)
    matches["players"]["vx"][:, 6] = run
    set_defensive_lines(matches[0])
    assert matches["second_last"][0, RIGHT] == pytest.approx(line, abs=0.1)


def test_nobody_supports_from_an_offside_place() -> None:
    matches = alone([*KEEPERS, *FOUR, *THEIRS], (-20.0, 0.0), game_duration=1000, offsides=True)
    ahead = []
    for step in range(150):
        play(matches, [0])
        if step > 30:
            line = np.sort(matches["players"]["x"][:, 6:10], axis=1)[:, -1]
            front = matches["players"]["x"][:, 2:6].max(axis=1)
            favoured = (matches["team_in_possession"] == LEFT) & (matches["ball"]["x"] < line)
            ahead += list((front - np.maximum(line, 0.0))[favoured])
    assert np.percentile(ahead, 90) < 2.0


@pytest.mark.parametrize(("away", "choices"), [(25.0, 2), (8.0, 6)])
def test_far_from_the_ball_a_player_chooses_anew_at_the_end_of_a_stride(away: float, choices: int) -> None:
    """As documented: that is every quarter of a second, not for all at once; within 10 m of the ball in every step."""
    players = [*KEEPERS, (-1.0, 0.0, LEFT, CM), (away, 0.0, LEFT, CM), (1.0, 0.0, RIGHT, CM)]
    match = alone(players, (0.0, 0.0), n=1)[0]
    match["team_in_possession"], match["chaser"] = LEFT, (2, 4)
    player, chosen = match["players"][3], 0
    match["step"] = 20
    for player["shirt"] in range(6):
        player["desired_vx"], player["place_step"] = 99.0, 19
        take_position(match, 3)
        chosen += player["desired_vx"] != 99.0
    assert chosen == choices


def test_a_striker_before_an_open_goal_shoots() -> None:
    matches = alone([(-50.0, 0.0, LEFT, GK), (44.0, 2.0, LEFT, CF), (-40.0, 0.0, RIGHT, GK)], (44.4, 2.0))
    play(matches, [0] * 30)
    assert np.mean(matches["score"][:, 0] == 1) > 0.8


def test_a_ball_that_comes_to_a_striker_is_shot_before_he_owns_it() -> None:
    matches = alone([(-50.0, 0.0, LEFT, GK), (43.0, 3.0, LEFT, CF), (54.0, 0.0, RIGHT, GK)], (43.0, 15.0))
    matches["ball"]["vy"] = -11.0
    owned, shot = np.zeros((2, len(matches)), bool)
    for _ in range(25):
        play(matches, [0])
        shot |= (matches["ball"]["vx"] > 15.0) & ~owned
        owned |= matches["reported_owner"] == 1
    assert shot.mean() >= 0.15


def test_a_pressed_player_passes_to_the_mate_who_is_free_ahead() -> None:
    players = [
        *KEEPERS,
        (0.0, 0.0, LEFT, CM),
        (12.0, 12.0, LEFT, CM),
        (2.5, 0.0, RIGHT, CB),
        (30.0, -20.0, RIGHT, CB),
    ]
    matches = alone(players, (0.4, 0.0))
    passed = np.zeros(len(matches), bool)
    for _ in range(40):
        play(matches, [0])
        passed |= matches["last_touch"] == 3
    assert passed.mean() > 0.6


def test_a_pass_is_as_long_as_the_way_to_the_mate() -> None:
    """Measured: of 88 drawn carriers with one mate beyond 32 m, .67 passed along the ground and .10 high."""
    matches = alone([*KEEPERS, (-20.0, 0.0, LEFT, CM), (25.0, 14.0, LEFT, CM), (-12.0, -6.0, RIGHT, CB)], (-19.6, 0.0))
    passed = np.zeros(len(matches), bool)
    for _ in range(10):
        passed |= np.isin(matches["players"]["kick"][:, 2], [SHORT_PASS, LONG_PASS, HIGH_PASS])
        play(matches, [0])
    assert passed.mean() > 0.5


def test_who_dribbles_beside_the_goal_keeps_off_its_line() -> None:
    """Measured: of 75 drawn there nobody led it over the goal line. Here .03; .70 with the pushes of before."""
    matches = alone([*KEEPERS, (38.0, 14.0, LEFT, CM), (44.0, 4.0, RIGHT, CB)], (38.4, 14.0))
    matches["players"]["vx"][:, 2] = matches["ball"]["vx"] = 5.0
    out = np.zeros(len(matches), bool)
    for _ in range(40):
        play(matches, [0])
        beside = (np.abs(matches["ball"]["y"]) > 4.0) & (matches["players"]["kick"][:, 2] == 0)
        out |= (matches["last_touch"] == 2) & (matches["ball"]["x"] > 54.5) & beside
    assert out.mean() < 0.1


def test_many_opponents_push_no_harder_than_the_goal_pulls() -> None:
    """One 8 m off pushes as measured; four that stand close together would keep him from ever coming near the goal."""
    one = alone([*KEEPERS, (0.0, 0.0, LEFT, CM), (8.0, 0.0, RIGHT, CB)], (0.4, 0.0))[0]
    assert push_of_rivals(one, one.players[2]) == pytest.approx((-0.52, 0.0), abs=0.01)
    backs = [(2.0, y, RIGHT, CB) for y in (-3.0, -1.0, 1.0, 3.0)]
    many = alone([*KEEPERS, (0.0, 0.0, LEFT, CM), *backs], (0.4, 0.0))[0]
    assert push_of_rivals(many, many.players[2]) == pytest.approx((-1.0, 0.0), abs=0.01)


def test_defenders_clear_under_pressure() -> None:
    players = [*KEEPERS, (-40.0, 5.0, LEFT, CB), (-38.0, 5.0, RIGHT, CF), (-38.0, 7.0, RIGHT, CF)]
    matches = alone(players, (-40.0, 5.4), right_team_difficulty=0.05)
    height = np.zeros(len(matches))
    for _ in range(25):
        play(matches, [0])
        height = np.maximum(height, matches["ball"]["z"])
    assert np.mean(height > 1.5) > 0.3


def test_in_a_team_with_agents_built_in_mates_leave_kicks_to_them() -> None:
    players = [*KEEPERS, (44.0, 2.0, LEFT, CF), (-20.0, 2.0, LEFT, CM)]
    matches = position(players, (44.4, 2.0), OPEN, range(20))
    for _ in range(25):
        take_over(matches, 3)
        play(matches, [0], player=3)
        assert not np.any(matches["players"]["kick"][:, 2] == SHOT)


@pytest.mark.parametrize("sizes", [(1, 1), (2, 5), (11, 1), (11, 11)])
def test_any_number_of_players_plays(sizes: tuple[int, int]) -> None:
    players = []
    for team, size in enumerate(sizes):
        side = 1.0 if team == RIGHT else -1.0
        for i in range(size):
            players.append((side * (50.0 - 4.0 * i), -20.0 + 4.0 * i, team, GK if i == 0 else CM))
    matches = alone(players, (0.0, 0.0), n=8, game_duration=2000)
    play(matches, [0] * 300)
    assert np.all(np.isfinite(matches["players"]["x"][:, : sum(sizes)]))
    assert np.all(matches["fault"] == 0)


def test_a_back_who_comes_too_late_gives_the_ball_up_before_its_first_touch():
    """In the real engine he turns as soon as the ball is near its man, and wins it within 13 steps in 24 of 24."""
    scene = """
param end_episode_on_possession_change = True
ego = LeftCB at 70 @ 30
LeftCF at 70 @ 0
Ball at 70 @ 28
RightCB at 75 @ 30
RightGK at 99 @ 0
LeftGK at -99 @ 0
"""
    env = FootballVectorEnv(scene, 32, config=FootballConfig(control="1"))
    env.reset(seed=0)
    lost = np.zeros(32, bool)
    for key in [6] * 5 + [17] + [6] * 8:
        lost |= env.step(np.full(32, key))[4]["ended"] == POSSESSION
    assert lost.mean() > 0.7
