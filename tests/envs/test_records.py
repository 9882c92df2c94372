"""A football program with a compose block: one environment, a row of the batch and the reference record the same."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from reference_match import ReferenceMatch

from regista.envs.football.gym_env import FootballEnv
from regista.envs.football.vector_env import FootballVectorEnv

PROGRAM = Path(__file__).parents[1] / "programs" / "football" / "attack_in_phases.scenic"
STEPS = 45


@pytest.mark.slow
def test_a_row_of_the_batch_records_what_one_environment_does():
    batch, one = FootballVectorEnv(PROGRAM, 3), FootballEnv(PROGRAM)
    batch.reset(seed=4)
    level = batch.levels[0]
    one.reset(seed=0, options={"theta": level["theta"]})
    for drawn in ("random", "players"):  # the stream, and the stances that it has given
        one.batch._batch.matches[drawn] = batch._batch.matches[drawn][0]
    for step in range(STEPS):
        _, rewards, _, _, info = batch.step(np.zeros(3, int))
        _, reward, _, _, own = one.step(0)
        assert reward == rewards[0]
        there = {name: values[0] for name, values in info["records"].items() if not np.isnan(values[0]).any()}
        assert there.keys() == own["records"].keys(), step
        assert all(np.array_equal(there[name], own["records"][name]) for name in there)


@pytest.mark.slow
def test_records_of_a_match_are_those_of_the_reference():
    env = FootballVectorEnv(PROGRAM, 1)
    env.reset(seed=4)
    level = env.levels[0]
    theirs = ReferenceMatch(env.program, level["theta"], int(level["seed"]))
    found = {"tightness": [], "side": None}
    for step in range(STEPS):
        info = env.step(np.zeros(1, int))[4]
        theirs.step(0)
        records = info["records"]
        if step == 0:
            found["side"] = float(records["side"][0])
        if not np.isnan(records["tightness"][0]):
            found["tightness"].append((step + 1, float(records["tightness"][0])))
    assert len(found["tightness"]) > 20
    assert found == {name: theirs.reference.records[name] for name in found}


def test_the_last_records_are_those_before_the_match_starts_again():
    text = PROGRAM.read_text().replace("game_duration = 400", "game_duration = 6")
    env = FootballVectorEnv(text, 2)
    env.reset(seed=4)
    for step in range(13):
        _, _, _, truncated, info = env.step(np.zeros(2, int))
        assert truncated.tolist() == [step % 6 == 5] * 2
        assert np.isnan(info["records"]["end"]).any() == (step % 6 != 5)
        assert np.isnan(info["records"]["side"]).any() == (step % 6 != 0)
