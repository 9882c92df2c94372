"""On the football programs in which something happens, compiled path and reference interpreter play the same match."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from reference_match import ReferenceMatch

from regista.envs.football.constants import DURATION, NUM_ACTIONS, REJECTED, RUNNING, TERMINATED
from regista.envs.football.gym_env import FootballEnv
from regista.envs.football.scenic.domain import FOOTBALL
from regista.envs.football.state import MATCH
from regista.envs.football.vector_env import FootballVectorEnv
from scenic_lite import ScenicError, load
from scenic_lite.dynamics.machine.bytecode import NO_COMMAND
from tests.football_programs import DYNAMIC, FILES, MODULES, name_of

# Programs of one folder are much alike: the first is always played, the others with the slow tests.
SAMPLES = [
    pytest.param(folder, part, marks=[pytest.mark.slow] * (part == "others"), id=f"{folder}-{part}")
    for folder in sorted({path.parent.name for path in DYNAMIC})
    for part in ("first", "others")
]


def sample(folder: str, part: str) -> list[Path]:
    found = [path for path in DYNAMIC if path.parent.name == folder]
    return found[:1] if part == "first" else found[1:]


@pytest.mark.long
def test_programs_are_as_the_tables_have_them() -> None:
    for path in FILES:
        if name_of(path) in MODULES:
            with pytest.raises(ScenicError, match="sets no ego"):
                load(path, FOOTBALL)
            continue
        program = load(path, FOOTBALL)
        attached = any(info.behavior for info in program.objects)
        happens = attached or program.monitors or program.terminations or program.temporal
        assert bool(happens) == (path in DYNAMIC), path


def both_play(path: Path, count: int, steps: int) -> None:
    """Play `count` levels both ways with random actions of the learner, until their first episode is over."""
    env = FootballVectorEnv(path, count)
    env.reset(seed=7)
    references = [ReferenceMatch(env.program, level["theta"], int(level["seed"])) for level in env.levels]
    going = set(range(count))
    actions = np.random.default_rng(2).integers(0, NUM_ACTIONS, (steps, count))
    for step, row in enumerate(actions):
        _, rewards, terminated, truncated, info = env.step(row)
        after = np.asarray(env.matches).view(MATCH)
        for k in sorted(going):
            moment = references[k].step(int(row[k]))
            where = f"{path.name}, level {k}, step {step}"
            wanted = [actions[0] if actions else NO_COMMAND for actions in moment.commands.actions]
            assert env._batch.commands[k].tolist() == wanted, where
            assert rewards[k] == moment.goal + moment.verdict.reward, where
            assert info["ended"][k] == ending(moment), where
            if terminated[k] or truncated[k]:
                going.remove(k)
            else:
                assert (after[k] == np.asarray(references[k].matches).view(MATCH)[0]).all(), where


def ending(moment) -> int:
    if moment.verdict.rejected:
        return REJECTED
    if moment.ended in (RUNNING, DURATION) and moment.verdict.terminated:
        return TERMINATED
    return moment.ended


@pytest.mark.slow
@pytest.mark.sample(3)
@pytest.mark.parametrize(("folder", "part"), SAMPLES)
def test_compiled_behaviors_play_as_the_reference_does(folder: str, part: str) -> None:
    for path in sample(folder, part):
        both_play(path, 1, 300)


@pytest.mark.slow
@pytest.mark.sample(3)
@pytest.mark.parametrize(("folder", "part"), SAMPLES)
def test_the_single_environment_plays_as_the_batch_does(folder: str, part: str) -> None:
    for path in sample(folder, part):
        single_plays_as_batch(path)


def single_plays_as_batch(path: Path) -> None:
    single, batch = FootballEnv(path), FootballVectorEnv(path, 3)
    first, _ = single.reset(seed=3)
    batch.reset(seed=0)
    rows, _ = batch.reset_to_levels(np.repeat(single.batch.levels, 3))
    assert (rows == first).all(), path
    for action in np.random.default_rng(5).integers(0, NUM_ACTIONS, 150):
        one = single.step(int(action))
        observations, rewards, terminated, truncated, info = batch.step(np.full(3, action))
        over = one[2] or one[3]
        assert (rewards == one[1]).all() and (terminated == one[2]).all() and (truncated == one[3]).all(), path
        assert ((info["final_obs"] if over else observations) == one[0]).all(), path
        if over:
            break
