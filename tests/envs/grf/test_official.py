"""The real engine behind our interface against the official environment, bit for bit; skipped where it is not there."""

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest

from regista.envs.football.config import FootballConfig
from regista.envs.football.constants import TERMINATED
from regista.envs.football.vector_env import FootballVectorEnv
from regista.envs.grf import engine
from regista.minigames.suites import HERE as HOME
from tests.envs.grf.fixtures import HERE, real_python

ACADEMIES = (
    *("empty_goal_close", "run_to_score_with_keeper", "pass_and_shoot_with_keeper", "3_vs_1_with_keeper"),
    "counterattack_easy",
)
SEED = 7
KEYS = (0, 5, 5, 5, 13, 12, 11, 4, 6, 9, 17, 18, 16)


def official(python: str, folder: Path, **asked: object) -> dict[str, np.ndarray]:
    """Play the official environment: see `official`."""
    (folder / "request.json").write_text(json.dumps(asked))
    words = [python, str(HERE / "official.py"), str(folder / "request.json"), str(folder / "result.npz")]
    subprocess.run(words, check=True, capture_output=True)
    with np.load(folder / "result.npz") as archive:
        return dict(archive)


def academy(scene: str) -> Path:
    """Return the program of an academy scene."""
    return HOME / "academy" / f"{scene}.scenic"


def make(python: str, program: str | Path, **settings: object) -> FootballVectorEnv:
    config = FootballConfig(**{"control": "active", "engine": "grf", "grf_python": python, "grf_workers": 1} | settings)
    return FootballVectorEnv(program, 1, config=config)


@pytest.fixture(name="same_seed")
def _same_seed(monkeypatch):
    monkeypatch.setattr(engine, "draw_seeds", lambda matches, where: np.full(len(where), SEED))


@pytest.mark.slow
@pytest.mark.parametrize("scene", ACADEMIES)
def test_an_academy_is_the_official_one(scene, tmp_path, same_seed):
    python = real_python()
    actions = np.random.default_rng(1).choice(KEYS, (80, 1))
    asked = {"scenario": f"academy_{scene}", "seed": SEED, "agents": [1, 0], "action_set": "default"}
    expected = official(python, tmp_path, actions=actions.tolist(), rewards="scoring,checkpoints", **asked)
    env = make(python, academy(scene), representation="simple115", rewards="scoring,checkpoints")
    seen = [env.reset(seed=0)[0]]
    rewards, dones = [], []
    for action in actions:
        observation, reward, terminated, truncated, info = env.step(action)
        dones.append(bool(terminated[0] or truncated[0]))
        rewards.append(reward)
        seen.append(info["final_obs"] if dones[-1] else observation)
        if dones[-1]:
            break
    np.testing.assert_array_equal(dones, expected["dones"])
    np.testing.assert_allclose(rewards, expected["rewards"], atol=1e-6)
    np.testing.assert_array_equal(np.array(seen), expected["simple115"])
    env.close()


@pytest.mark.slow
def test_a_team_of_agents_is_the_official_one(tmp_path, same_seed):
    """Right players too: theirs is the frame of their own team."""
    python = real_python()
    actions = np.random.default_rng(2).choice(KEYS, (40, 6))
    asked = {"scenario": "academy_3_vs_1_with_keeper", "seed": SEED, "agents": [4, 2], "action_set": "v2"}
    expected = official(python, tmp_path, actions=actions.tolist(), rewards="scoring", **asked)
    env = make(python, academy("3_vs_1_with_keeper"), representation="raw", control="all", right_control="all")
    observation = env.reset(seed=0)[0]
    for step in range(len(expected["dones"]) + 1):
        for agent, raw in enumerate(observation):
            for name in ("ball", "left_team", "right_team", "left_team_direction", "sticky_actions", "active"):
                np.testing.assert_allclose(raw[name][0], expected[f"{name} {agent}"][step], atol=1e-9, err_msg=name)
        if step < len(actions):
            observation, _, terminated, truncated, info = env.step(actions[step : step + 1])
            observation = info["final_obs"] if (terminated | truncated)[0] else observation
    env.close()


@pytest.mark.slow
@pytest.mark.parametrize("scene", ["3_vs_1_with_keeper", "counterattack_easy"])
def test_both_engines_begin_alike(scene):
    real, ours = (make(real_python(), academy(scene), engine=engine) for engine in ("grf", "regista"))
    for env in (real, ours):
        env.reset(seed=0)
    for name in ("x", "y", "team", "role"):
        places = [env.matches["players"][name] for env in (real, ours)]
        np.testing.assert_allclose(*places, atol=1e-3)  # m
    for name in ("x", "y", "z"):
        np.testing.assert_allclose(real.matches["ball"][name], ours.matches["ball"][name], atol=1e-3)
    for _ in range(2):  # who is active at first, and after the first step
        assert real.matches["agents"][:, 0].tolist() == ours.matches["agents"][:, 0].tolist()
        for env in (real, ours):
            env.step(np.zeros(1, int))
    real.close()


@pytest.mark.slow
def test_what_was_played_is_repeated_bit_for_bit():
    python = real_python()
    env = make(python, academy("3_vs_1_with_keeper"))
    env.reset(seed=3)
    rng = np.random.default_rng(0)
    for action in rng.choice(KEYS, (30, 1)):
        env.step(action)
    twin = env.copy()  # repeats all of it on another engine, and checks what it shows
    for action in rng.choice(KEYS, (30, 1)):
        results = [each.step(action) for each in (env, twin)]
        for ours, theirs in zip(results[0][:4], results[1][:4], strict=True):
            np.testing.assert_array_equal(ours, theirs)
    env.close()
    twin.close()


@pytest.mark.slow
def test_behaviors_and_monitors_play_on_the_real_engine():
    program = """
behavior RunAndShoot():
    while self.x < 75:
        take SetDirection(5), Sprint()
    while True:
        take Shoot()
        take NoAction()

monitor Pay():
    while True:
        simulation().scenic_reward = 0.25
        wait

LeftGK at -98 @ 0
ego = LeftCF at 60 @ 0, with behavior RunAndShoot()
RightGK at 98 @ 30
Ball ahead of ego by 2
terminate when simulation().score_left > 0
require monitor Pay()
"""
    env = make(real_python(), program.replace("score_left", "game_ds.score_left"), control="closest1")
    env.reset(seed=0)
    twin = env.with_scripted_policy()
    for _ in range(80):
        _, rewards, terminated, _, info = twin.step(np.array([0]))
        if terminated[0]:
            break
        assert rewards[0] == 0.25
    assert terminated[0] and info["ended"][0] == TERMINATED
    assert rewards[0] == 1.25  # the goal, and what the monitor pays
    twin.close()
    env.close()
