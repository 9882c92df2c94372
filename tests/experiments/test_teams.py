"""Teams on the command line: trained, gone on with, tested, played in two engines, refused."""

import csv
import dataclasses

import numpy as np
import pytest

from regista.envs.football.task import football_task
from regista.experiments.__main__ import main
from regista.experiments.run.build import make_matches, make_method
from regista.experiments.run.errors import CommandError
from regista.experiments.run.evaluator import load_student
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.games import single_game
from regista.experiments.run.table import read_rows
from regista.experiments.transfer.episodes import NO_ACTION, play, play_keys
from regista.experiments.transfer.replaying import leaving

GAME = "3v2FourBehaviors"
SHORT = ["--num-envs", "4", "--num-steps", "16", "--eval-every", "0", "--eval-episodes", "1", "--no-record"]


@pytest.mark.long
def test_a_team_is_trained_gone_on_with_tested_and_carried_over(tmp_path, capsys):
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    team = ["--control", "closest2", "--team", "shared", "--critic", "central", "--method", "dr"]
    assert main(["train", GAME, "--out", str(whole), "--total-env-steps", "192", *team, *SHORT]) == 0
    assert main(["train", GAME, "--out", str(parts), "--total-env-steps", "64", *team, *SHORT]) == 0
    assert main(["train", "--resume", str(parts), "--total-env-steps", "192"]) == 0
    rows = [
        [{name: cell for name, cell in row.items() if not name.startswith("time/")} for row in read_rows(path)]
        for path in (whole / "metrics.csv", parts / "metrics.csv")
    ]
    assert rows[0] == rows[1] and len(rows[0]) == 3
    assert {"student/agent_1/entropy", "student/agent_0/action_18"} <= set(rows[0][0])
    few = ["--episodes", "4", "--levels", "0"]
    assert main(["evaluate", str(whole), *few, "--csv", str(tmp_path / "results.csv")]) == 0
    with open(tmp_path / "results.csv") as file:
        assert {row["method"] for row in csv.DictReader(file)} == {"dr", "shoot", "random", "built-in"}
    asked = ["--engine", "regista", "--episodes", "2", "--grf-episodes", "2", "--policies", "greedy"]
    traces = ["--traces", str(tmp_path / "traces.rrd"), "--trace-episodes", "1"]
    assert main(["transfer", str(whole), *asked, *traces]) == 0
    assert "features outside the range of our episodes: never" in capsys.readouterr().out  # both engines are ours


@pytest.mark.slow
@pytest.mark.parametrize(
    ("flags", "message"),
    [
        (["--control", "9"], "train.scenic: control '9' needs 9 players in the left team, which has 4"),
        (["--control", "all", "--right-control", "1", "--critic", "central"], "opponents have different values"),
        (["--team", "both"], "invalid choice: 'both'"),
    ],
)
def test_what_does_not_fit_is_refused_in_one_sentence(flags, message, tmp_path, capsys):
    assert main(["train", GAME, "--out", str(tmp_path / "run"), *flags, *SHORT]) != 0
    said = capsys.readouterr().err.strip().splitlines()[-1]
    assert said.startswith("regista: ") and message in said
    assert not (tmp_path / "run" / "metrics.csv").exists()


@pytest.mark.long
def test_a_student_of_another_number_of_agents_is_refused(tmp_path, capsys):
    run = tmp_path / "run"
    assert main(["train", GAME, "--out", str(run), "--total-env-steps", "64", "--control", "2", *SHORT]) == 0
    text = (run / "config.json").read_text()
    (run / "config.json").write_text(text.replace('"control": "2"', '"control": "3"'))
    before = (run / "checkpoint.pt").read_bytes()
    wanted = "the checkpoint holds a student of 2 agents, the environments have 3"
    for command in (["evaluate", str(run)], ["train", "--resume", str(run), "--total-env-steps", "128"]):
        assert main(command) == 1
        assert wanted in capsys.readouterr().err
    assert before == (run / "checkpoint.pt").read_bytes()
    with pytest.raises(CommandError, match=wanted):
        load_student(RunFolder.open(run), single_game(GAME))


def loaded(control="all", num_envs=3):
    from regista.envs.football.config import FootballConfig
    from regista.envs.football.vector_env import FootballVectorEnv
    from regista.minigames import MINIGAMES

    env = FootballVectorEnv(MINIGAMES[GAME].program, num_envs, config=FootballConfig(control=control))
    env.reset(seed=0)
    return env


@pytest.mark.slow
def test_episodes_keep_what_each_agent_did_and_saw():
    env = loaded()
    levels, rng = env.sample_levels(4), np.random.default_rng(0)
    played = play(env, lambda seen, step: rng.integers(0, 19, (3, 4)), levels, steps=30, observed=True)
    assert played.actions.shape[::2] == (4, 4) and played.observations.shape[2:] == env.single_observation_space.shape
    done = np.arange(played.actions.shape[1]) >= played.lengths[:, None]
    assert (played.actions[done] == NO_ACTION).all() and (played.actions[~done] >= 0).all()
    again = play_keys(env, np.maximum(played.actions, 0), levels)
    np.testing.assert_array_equal(again.places, played.places)


def test_what_one_agent_sees_outside_counts_for_the_team():
    outside = np.zeros((2, 3, 4, 2), bool)
    outside[1, 2, 3, 0] = True
    found = leaving(outside, ("x", "y"))
    assert (found.share, found.step, found.first) == (0.5, 2.0, ("x",))


@pytest.mark.slow
def test_the_baselines_play_for_every_agent():
    import torch

    env = loaded("closest3")
    for policy in football_task(env.program).make_baselines(env).values():
        env.step(policy.play(env.observe(), torch.Generator().manual_seed(0)))


@pytest.mark.slow
@pytest.mark.sample(4)
@pytest.mark.parametrize(
    ("control", "representation", "agents"),
    [
        *((f"closest{k}", "features", k) for k in (1, 2, 3)),
        *(("2", "features", 2), ("all", "simple115", 4), ("allNonGK", "features", 3), ("closest2", "smm", 2)),
    ],
)
def test_students_learn_in_every_control_mode(control, representation, agents):
    game = single_game(GAME)
    config = game.start("fast")
    env = dataclasses.replace(config.env, control=control, representation=representation)
    ppo = dataclasses.replace(config.ppo, num_steps=4, num_minibatches=1, update_epochs=1)
    upomdp = make_matches(game.program(config), 2, env, 0)
    method = make_method(dataclasses.replace(config, method="paired", env=env, ppo=ppo, num_envs=2), upomdp)
    metrics = method.update()
    assert metrics["env_steps"] == 2 * 2 * 4 and metrics["protagonist/grad_norm"] > 0
    told = {name for name in metrics if name.startswith("protagonist/agent_") and name.endswith("/entropy")}
    assert len(told) == (agents if agents > 1 else 0)
