"""What environments report of their success: 1, 0 or unknown, at the end of every episode or of none."""

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import Box, Discrete
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from gymnasium.wrappers.vector import DictInfoToList

from ued import DR, GymUPOMDP, ThetaSpace, UPOMDPWrapper, VectorUPOMDP
from ued.adapters.curriculum_wrapper import CurriculumFeed, CurriculumWrapper
from ued.core.level_space import LevelError
from ued.evaluation import evaluate
from ued.methods.alp_gmm import ALPGMMConfig, ALPGMMCurriculum

NONE = object()  # no report


class Told(gymnasium.Env):
    """One step, paid 1. Reports what its level says."""

    observation_space, action_space = Box(0, 1, (1,), np.float32), Discrete(2)
    said = NONE

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.said = REPORTS[int((options or {"said": 0})["said"])]
        return np.zeros(1, np.float32), {}

    def step(self, action):
        return np.zeros(1, np.float32), 1.0, True, False, {} if self.said is NONE else {"success": self.said}


REPORTS = [NONE, True, False, None, np.float32(1), 0.7, -1, 5.0, np.array(1)]
THETA, SOLVED_ONLY = {"said": (0.0, len(REPORTS) - 1.0)}, {"said": (0.0, 1.99)}


def single(count, theta=THETA):
    return GymUPOMDP(Told, lambda env, values: values, theta, count)


def batch(mode):
    made = lambda count: SyncVectorEnv([Told] * count, autoreset_mode=mode)  # noqa: E731
    return lambda count: VectorUPOMDP(made, "each", THETA, count)


KINDS = [single, *map(batch, AutoresetMode)]


def reports(make, *said):
    """Return the success that one step reports in environments whose levels report this, by their index."""
    env = make(len(said))
    env.reset(seed=0, options={"theta": [env.theta_of({"said": float(index)}) for index in said]})
    return env.advance(np.zeros(len(said), int))[4]["success"]


@pytest.mark.parametrize("make", KINDS)
def test_true_false_and_numbers(make):
    np.testing.assert_array_equal(reports(make, 1, 2, 1, 4), [1, 0, 1, 1])
    np.testing.assert_array_equal(reports(make, 0, 0), [np.nan, np.nan])
    np.testing.assert_array_equal(reports(make, 3, 3), [np.nan, np.nan])


def test_an_unknown_success_beside_a_known_one():
    np.testing.assert_array_equal(reports(single, 1, 3, 2), [1, np.nan, 0])
    np.testing.assert_array_equal(reports(single, 8, 2), [1, 0])


@pytest.mark.parametrize("make", KINDS)
@pytest.mark.parametrize("index", [5, 6, 7])
def test_other_numbers_are_refused(make, index):
    with pytest.raises(LevelError, match=r"reported the success .*; it must be True or False .*level: theta"):
        reports(make, index, index)


@pytest.mark.parametrize("make", KINDS)
@pytest.mark.parametrize("said", [(0, 1), (1, 0), (0, 2)])
def test_a_report_of_some_episodes_is_refused(make, said):
    with pytest.raises(LevelError, match="unlike earlier ones; report 'success' at the end of every episode"):
        reports(make, *said)


def test_a_report_of_later_episodes_only_is_refused():
    env = single(1)
    for index in (0, 1):
        env.reset(seed=0, options={"theta": [env.theta_of({"said": float(index)})]})
        if index:
            with pytest.raises(LevelError, match="environment 0: the episode that ended has a report"):
                env.advance(np.zeros(1, int))
        else:
            env.advance(np.zeros(1, int))


def test_training_and_evaluation_tell_the_user():
    method = DR(single(8, SOLVED_ONLY), seed=0)
    with pytest.raises(LevelError, match="unlike earlier ones"):
        method.update()
    with pytest.raises(LevelError, match="unlike earlier ones"):
        evaluate(method.student, single(4, SOLVED_ONLY), 64, 0)


def test_in_a_foreign_trainer_too():
    env = UPOMDPWrapper(Told(), lambda env, values: values, SOLVED_ONLY)
    wrapped = CurriculumWrapper(env, CurriculumFeed(ALPGMMCurriculum(ThetaSpace(1), ALPGMMConfig(), seed=0)))
    with pytest.raises(LevelError, match="unlike earlier ones"):
        for _ in range(50):
            wrapped.reset()
            wrapped.step(0)


class Unsaid(SyncVectorEnv):
    """Resets in the same step without saying so, or reports its success beside the observations of the next episode."""

    def __init__(self, count, mode, beside):
        super().__init__([Told] * count, autoreset_mode=AutoresetMode.SAME_STEP)
        self.metadata = {} if mode is None else {"autoreset_mode": mode}
        self.beside = beside

    def step(self, actions):
        *rest, info = super().step(actions)
        if self.beside:
            info |= info.pop("final_info")
        return *rest, info


@pytest.mark.parametrize("beside", [False, True])
@pytest.mark.parametrize("mode", [None, AutoresetMode.SAME_STEP])
def test_success_of_a_batch_that_resets_in_the_same_step(mode, beside):
    make = lambda count: VectorUPOMDP(lambda n: Unsaid(n, mode, beside), "each", THETA, count)  # noqa: E731
    np.testing.assert_array_equal(reports(make, 1, 2), [1, 0])


def test_infos_that_are_a_list_are_refused():
    made = lambda count: DictInfoToList(SyncVectorEnv([Told] * count, autoreset_mode=AutoresetMode.DISABLED))  # noqa: E731
    with pytest.raises(LevelError, match=r"info must be a dict of arrays, got .*; leave out DictInfoToList"):
        reports(lambda count: VectorUPOMDP(made, "each", THETA, count), 1, 2)
