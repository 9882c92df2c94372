"""Simulations of Scenic itself as a UPOMDP: episodes that repeat, end, are replaced, resumed, and trained on.

Read next: `scenic3_probes`, the programs.
"""

import os
import pickle
import random
import re
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from tests.envs.scenic3_probes import DRIVE, MODULAR, ROOT, STILL, load_program, needed, scenic3
from ued.core.level_space import LevelError


@pytest.fixture
def load(tmp_path):
    """Write a program and load it."""
    return partial(load_program, tmp_path)


if scenic3 is not None:
    from gymnasium.spaces import Box

    class Pusher(scenic3.Role):
        """Sees where both are; sets its own speed."""

        observation_space = Box(-np.inf, np.inf, (3,), np.float32)
        action_space = Box(-9.0, 9.0, (1,), np.float32)
        max_steps = 30
        mistaken = False

        def observe(self, simulation):
            ego, other, *_ = simulation.objects
            return np.array([ego.position.y, other.position.x, other.position.y], np.float32)

        def act(self, action, simulation):
            if self.mistaken:
                raise RuntimeError("my mistake")
            simulation.objects[0].velocity = type(simulation.objects[0].velocity)(0, float(action[0]))
            return ()

        def judge(self, simulation):
            ego, other, *_ = simulation.objects
            return float(ego.position.y), bool(ego.position.y > other.position.y), None


def played(upomdp, steps=20, seed=0):
    """Play with random actions; return all that was seen."""
    rng, seen = np.random.default_rng(seed), []
    for _ in range(steps):
        outcome = upomdp.step(rng.uniform(-1, 2, (upomdp.num_envs, 1)))
        seen.append(np.concatenate([outcome[0].ravel(), *(np.asarray(part, float) for part in outcome[1:4])]))
    return np.array(seen)


@pytest.fixture
def make(load):
    """Make environments of a program; they are closed at the end."""
    made = []

    def environments(text, num_envs=2):
        made.append(scenic3.ScenicUPOMDP(load(text), Pusher(), num_envs))
        return made[-1]

    yield environments
    for each in made:
        each.close()


@needed
def test_a_level_and_its_actions_repeat_an_episode(make):
    upomdp = make(STILL)
    levels = upomdp.sample_levels(2)
    upomdp.reset_to_levels(levels)
    first = played(upomdp)
    upomdp.reset_to_levels(levels)
    np.testing.assert_array_equal(first, played(upomdp))
    other = levels.copy()
    other["seed"] += 1
    upomdp.reset_to_levels(other)
    assert not np.array_equal(first, played(upomdp))


@needed
def test_episodes_of_a_level_differ_by_luck_alone(make):
    """Objects stand where they stood; behaviors draw anew in each episode, and alike in both students' environments."""
    upomdp, other = make(STILL), make(STILL)
    levels = upomdp.sample_levels(2)
    seen, courses = [], []
    for episode in range(3):
        for each in (upomdp, other):
            starts = each.reset_to_levels(levels, None, 5)[0] if episode == 0 else each.play_again()
            seen.append(starts)
            courses.append(played(each, 6))
    assert all((starts == seen[0]).all() for starts in seen)
    for mine, theirs in zip(courses[::2], courses[1::2], strict=True):
        np.testing.assert_array_equal(mine, theirs)
    assert len({course.tobytes() for course in courses}) == 3


@needed
def test_episodes_end_by_the_program_the_role_and_the_clock(make):
    upomdp = make(DRIVE)
    theta = np.array(
        [upomdp.theta_of({"speed": 4.0, "other.position": 5.0}), upomdp.theta_of({"speed": 1.0, "other.position": 5.0})]
    )
    upomdp.reset(options={"theta": theta})
    endings = []
    for _ in range(31):
        _, _, terminated, truncated, info = upomdp.step(np.array([[0.0], [0.0]]))
        endings += [(int(k), bool(terminated[k]), info["ending"][k]) for k in np.flatnonzero(terminated | truncated)]
    assert endings[0][:2] == (0, True) and "line" in endings[0][2]
    assert endings[1][:2] == (1, False) and "time limit" in endings[1][2]
    upomdp.reset(options={"theta": theta})
    for _ in range(20):
        seen, reward, terminated, _, info = upomdp.step(np.array([[0.0], [9.0 - 0.5]]))
        if terminated.any():
            break
    assert terminated.tolist() == [False, True]
    assert info["final_obs"][1, 0] > info["final_obs"][1, 2] > seen[1, 0] == 0  # begun again
    assert reward[1] == pytest.approx(info["final_obs"][1, 0], rel=1e-6)


@needed
def test_a_requirement_that_is_broken_on_the_way_ends_an_episode(make):
    upomdp = make(STILL + "require always other.position.y < 7.2", 1)
    upomdp.reset(options={"theta": [[1.0, -1.0]]})
    outcomes = [upomdp.step(np.zeros((1, 1))) for _ in range(6)]
    assert [outcome[2].item() for outcome in outcomes] == [False] * 4 + [True, False]
    assert outcomes[4][4]["ending"].tolist() == ["rejected"] and outcomes[4][4]["success"].tolist() == [0]


@needed
def test_scenarios_of_several_parts_are_played(make):
    upomdp = make(MODULAR, 1)
    assert [draw.name for draw in upomdp.parameters] == ["param weather", "gap", "other.behavior.pace"]
    upomdp.reset(options={"theta": [[0.0, 0.0, -1.0]]})
    seen = [upomdp.step(np.zeros((1, 1)))[0][0] for _ in range(2)]
    np.testing.assert_allclose(seen, [[0, 0, 6.5], [0, 0.1, 6.5]], atol=1e-6)  # 4.5 m between two of 2 m
    assert len(played(upomdp, 40)) == 40


@needed
def test_without_an_ego_it_says_who_might_act(make):
    upomdp = make("param render = False\nmodel scenic.simulators.newtonian.model\nnew Object at (Range(0, 1), 0)", 1)
    with pytest.raises(LevelError, match=r"the program has no ego; override `Role.agent` to return the object"):
        upomdp.reset(seed=0)


@needed
def test_it_is_seen_from_above(make):
    upomdp = make(STILL)
    upomdp.reset(seed=0, options={"theta": [[0, -1], [0, 1]]})
    near, far = upomdp.render()
    assert near.dtype == np.uint8 and near.shape == far.shape == (160, 320, 3)
    heights = [np.argwhere((frame == scenic3.view.OTHER).all(-1))[:, 0].mean() for frame in (near, far)]
    assert heights[0] - heights[1] == pytest.approx(5 * 4, abs=1)  # five meters, of four pixels


@needed
def test_it_is_a_vector_environment(make):
    upomdp = make(STILL)
    seen, info = upomdp.reset(seed=0, options={"theta": [[-1, -1], [1, 1]]})
    assert seen.shape == (2, 3) and seen.dtype == np.float32
    np.testing.assert_allclose(seen[:, 2], [5, 10])
    assert not info["replaced"].any()
    assert upomdp.describe([[-1, 0]]) == [{"speed": 1.0, "other.position": 7.5}]


@needed
def test_a_process_that_dies_is_replaced_and_its_episode_repeated(make):
    upomdp, same = make(STILL), make(STILL)
    for each in (upomdp, same):
        each.reset(seed=3)
        played(each, 5)
    os.kill(upomdp.workers[1].pid, signal.SIGKILL)
    np.testing.assert_array_equal(played(upomdp, 5, 1), played(same, 5, 1))


@needed
@pytest.mark.slow
def test_no_process_outlives_the_one_that_began_it(load, tmp_path):
    path = load(STILL).file
    code = f"""
import sys; sys.path.insert(0, {str(ROOT)!r})
from tests.envs.test_scenic3_episodes import Pusher, scenic3
upomdp = scenic3.ScenicUPOMDP(scenic3.ScenicProgram({path!r}), Pusher(), 3)
upomdp.reset(seed=0)
print(*(worker.pid for worker in upomdp.workers), flush=True)
input()
"""
    with subprocess.Popen([sys.executable, "-c", code], stdin=-1, stdout=-1, text=True, cwd=ROOT) as owner:
        pids = [int(word) for word in owner.stdout.readline().split()]
        assert len(pids) == 3
        owner.kill()
    until = time.monotonic() + 30
    while any(running(pid) for pid in pids):
        assert time.monotonic() < until
        time.sleep(0.05)


def running(pid):
    """Whether there is such a process, and it has not ended without anybody's having asked."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@needed
@pytest.mark.slow
def test_a_process_that_hangs_is_replaced(make, monkeypatch):
    monkeypatch.setattr(scenic3.vector_env, "STEP_SECONDS", 0.0)
    monkeypatch.setattr(scenic3.vector_env, "BEGIN_SECONDS", 5.0)
    upomdp, same = make(STILL), make(STILL)
    for each in (upomdp, same):
        each.reset(seed=3)
    os.kill(upomdp.workers[0].pid, signal.SIGSTOP)
    np.testing.assert_array_equal(played(upomdp, 3), played(same, 3))


@needed
def test_a_state_goes_on_to_the_same_numbers(make):
    upomdp, same = make(STILL), make(STILL)
    upomdp.reset(seed=3)
    played(upomdp, 7)
    state = pickle.loads(pickle.dumps(upomdp.get_state()))
    same.set_state(state)
    np.testing.assert_array_equal(played(upomdp, 40, 1), played(same, 40, 1))


@needed
def test_a_mistake_tells_the_level(make):
    upomdp = make(STILL)
    upomdp.role.mistaken = True
    upomdp.reset(seed=3)
    where = r"failed after 1 steps \(theta \[.*\], seed \d+\): RuntimeError: my mistake\n.*in act"
    with pytest.raises(LevelError, match=re.compile(where, re.DOTALL)):
        upomdp.step(np.zeros((2, 1)))


@needed
def test_a_mistake_leaves_no_answer_for_the_next_request(make):
    """Both workers fail, or one: what the others answered is not taken for their next observation."""
    upomdp = make(STILL)
    upomdp.role.mistaken = True
    upomdp.reset(seed=3)
    with pytest.raises(LevelError, match="my mistake"):
        upomdp.step(np.zeros((2, 1)))
    observations, _ = upomdp.reset(seed=4)
    np.testing.assert_array_equal(observations, make(STILL).reset(seed=4)[0])


@needed
def test_what_is_drawn_outside_changes_nothing(load):
    program = load(STILL)
    simulator = program.scenario.getSimulator()

    def run(noise):
        episode = scenic3.Episode(program.scene(np.zeros(2), 1), simulator, Pusher(), 1)
        seen = [episode.begin()]
        for _ in range(10):
            noise()
            seen.append(episode.step([1.0])[0])
        episode.close()
        return np.array(seen)

    before = random.getstate()
    first = run(lambda: None)
    assert random.getstate() == before
    np.testing.assert_array_equal(first, run(random.random))


@needed
def test_inspect_shows_what_scenic_reads(load, capsys):
    from regista.experiments.__main__ import main

    path = load(DRIVE).file
    assert main(["inspect", path, "--engine", "scenic3"]) == 0
    told = capsys.readouterr().out
    assert "D = 2 free parameters" in told and "100.0% of 512" in told and "Wander" in told
    assert "sampled from the level's seed: ego.color, other.color" in told
    assert main(["inspect", path, "--engine", "scenic3", "--show", "scenes", "--theta", "0", "1"]) == 0
    assert "10.00" in capsys.readouterr().out
    Path(path).write_text("ego = new Nothing")
    assert main(["inspect", path, "--engine", "scenic3"]) == 1
    assert "Scenic rejects it" in capsys.readouterr().err


@needed
@pytest.mark.slow
def test_plr_and_paired_train_on_it(make):
    import ued

    for method, config in ((ued.PLR, ued.PLRConfig()), (ued.Paired, ued.PairedConfig())):
        trained = method(make(STILL), ued.PPOConfig(num_steps=8, hidden_size=8), config, seed=0)
        for _ in range(3):
            trained.update()
        assert trained.env_steps >= 48
