"""A state or a record from a stranger is refused in a sentence, or harms nobody."""

from __future__ import annotations

import numpy as np
import pytest

from regista.envs.football.config import FootballConfig
from regista.envs.football.limits import StateError
from regista.envs.football.state import MATCH, TABLES
from regista.envs.football.vector_env import FootballVectorEnv
from regista.minigames import MINIGAMES
from tests.envs.hostile import PLAYED, REFUSED, attack_records, attack_states


def make(count: int = 2) -> FootballVectorEnv:
    env = FootballVectorEnv(MINIGAMES["3v2FourBehaviors"].program, count, config=FootballConfig())
    env.reset(seed=0)
    return env


def test_every_whole_number_has_its_limits() -> None:
    for table in TABLES.values():
        for name, kind, *_ in table:
            assert kind != "i8", f"{name} may be any whole number"


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("num_players", 22, r"matches\[1\]\.num_players is 22; it must be 6, as in the program"),
        ("carrier", 6, r"matches\[1\]\.carrier is 6; it must be a whole number from -1 to 5"),
        ("score", (0, -1), r"matches\[1\]\.score\[1\] is -1; it must be a whole number from 0 to 1,000,000,000"),
        ("save_x", np.nan, r"matches\[1\]\.save_x is nan; it must be a number from -1e\+09 to 1e\+09"),
    ],
)
def test_a_number_that_cannot_be_is_refused_by_its_name(name: str, value: object, message: str) -> None:
    env = make()
    state = env.get_state()
    state["matches"][name][1] = value
    before = env.matches
    with pytest.raises(StateError, match=message):
        env.set_state(state)
    assert (env.matches == before).all()


def test_agents_players_and_truth_values_are_looked_at_too() -> None:
    env = make()
    state = env.get_state()
    state["matches"]["players"]["agent"][0, 3] = 1
    with pytest.raises(StateError, match=r"matches\[0\]\.players\[3\]\.agent is 1; it must be a whole number from -1"):
        env.set_state(state)
    state = env.get_state()
    state["starts"].view(np.uint8).reshape(2, -1)[1, MATCH.fields["offsides"][1]] = 7
    with pytest.raises(StateError, match=r"starts\[1\]\.offsides is the byte 7; it must be 0 or 1"):
        env.set_state(state)


def test_a_program_goes_on_only_where_it_has_rows() -> None:
    env = make()
    slot = int(env.behaviors.code.threads[0, 0])
    for value in (-1.0, np.nan, 1e300, float(len(env.behaviors.code.rows))):
        state = env.get_state()
        state["registers"][0, slot] = value
        with pytest.raises(StateError, match=rf"registers\[0\]\[{slot}\] is .*; it must be a number from 0 to"):
            env.set_state(state)


def test_an_environment_that_has_not_begun_can_be_copied() -> None:
    FootballVectorEnv(MINIGAMES["1v1Free"].program, 2).copy()


@pytest.mark.long
def test_states_with_one_number_changed() -> None:
    counts = attack_states(1800, 0)
    assert counts[REFUSED] > 300 and counts[PLAYED] > 300


@pytest.mark.long
def test_records_with_something_changed(tmp_path) -> None:
    counts = attack_records(120, 0, tmp_path)
    assert counts[REFUSED] > 60
