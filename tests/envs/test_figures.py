"""The listings of the thesis's chapter 2 in the simulator: behaviors, a monitor that pays, one that ends episodes."""

from pathlib import Path

import numpy as np
import pytest

from regista.envs.football.constants import BUILTIN_AI, HIGH_PASS, METRES_PER_X, TERMINATED
from regista.envs.football.scenic.domain import FOOTBALL
from regista.envs.football.scenic.world_table import BUT_HEADING, HEADING, NUM_FIELDS, UNREAD
from regista.envs.football.vector_env import FootballVectorEnv
from scenic_lite import ScenicError, load

PROGRAMS = Path(__file__).parents[1] / "programs"
RIGHT = 5  # the direction key


def text_of(figure):
    return (PROGRAMS / f"{figure}.scenic").read_text()


def started(text, count, seed=0):
    env = FootballVectorEnv(text, count)
    env.reset(seed=seed)
    return env


def player(env, name):
    return int(env.lineup.object_to_player[[info.name for info in env.program.objects].index(name)])


@pytest.mark.slow
def test_figure_2_1_the_cross_from_the_side():
    """The left mid crosses high once he has arrived; the others run to their points and wait for the ball."""
    env = started(text_of("figure_2_1"), 64)
    crosser, receiver = player(env, "right_LeftMid"), player(env, "ego")
    crossed, waited, over = np.zeros(64, bool), np.zeros(64, bool), np.zeros(64, bool)
    for _ in range(120):
        _, _, terminated, truncated, _ = env.step(np.zeros(64, int))
        over |= terminated | truncated
        actions = env.matches["players"]["action"]
        assert BUILTIN_AI not in actions[~over][:, [crosser, receiver]]
        crossed |= ~over & (actions[:, crosser] == HIGH_PASS)
        waited |= ~over & np.isin(actions[:, receiver], (14, 15))
    assert crossed.mean() > 0.5 and waited.mean() > 0.5


@pytest.mark.slow
@pytest.mark.parametrize("figure", ["figure_2_1", "figure_2_3", "figure_2_4"])
def test_what_a_program_is_not_shown_it_does_not_read(figure):
    """What is found in its code not to be read may be anything: the matches come out the same, bit for bit."""
    plain, spoilt = started(text_of(figure), 16), started(text_of(figure), 16)
    code, read = spoilt.behaviors.code, spoilt.behaviors.objects_read
    unread = np.zeros((len(read), NUM_FIELDS), bool)
    unread[read == UNREAD], unread[read == BUT_HEADING, HEADING] = True, True
    assert unread.any()
    for registers in (spoilt._batch.registers, spoilt._batch.start_registers):
        registers[:, code.world_base :][:, : unread.size][:, unread.ravel()] = np.nan
    for t in range(80):
        for env in (plain, spoilt):
            env.step(np.full(16, t % 19))
    assert (plain.matches == spoilt.matches).all()


def test_figure_2_3_pays_for_a_ball_near_the_goal():
    """As printed the condition asks for y where x is meant, so that nothing is ever paid; with x it is."""
    printed, meant = text_of("figure_2_3"), text_of("figure_2_3").replace("ball_y > 70", "ball_x > 70")
    for text, pays in ((printed, False), (meant, True)):
        env = started(text, 8)
        for _ in range(60):
            _, rewards, terminated, truncated, _ = env.step(np.full(8, RIGHT))
            going = ~(terminated | truncated)
            near = pays & (env.matches["ball"]["x"] / METRES_PER_X > 70)
            expected = env.matches["goal"] + np.where(near, 0.1, 0.0)
            assert rewards[going] == pytest.approx(expected[going])


@pytest.mark.slow
def test_figure_2_4_ends_when_the_ball_is_in_the_right_half():
    env = started(text_of("figure_2_4"), 8)
    ends = 0
    for _ in range(100):
        _, _, terminated, _, info = env.step(np.full(8, RIGHT))
        ended = info["ended"] == TERMINATED
        assert terminated[ended].all()
        going = info["ended"] == 0
        assert (env.matches["ball"]["x"][going] <= 0).all()
        ends += ended.sum()
    assert ends >= 8


@pytest.mark.parametrize("figure", ["figure_2_3", "figure_2_4"])
def test_as_printed_the_wait_stands_outside_the_loop_and_is_never_reached(figure):
    with pytest.raises(ScenicError) as error:
        load(text_of(figure).replace("\n        wait\n", "\n    wait\n"), FOOTBALL)
    assert error.value.line == 6
    name = text_of(figure).split("monitor ")[1].split(":")[0]
    assert f'the monitor "{name}" never waits: there is no "wait" in this loop' in str(error.value)
