"""Configurations as JSON: there and back, and what is refused."""

import dataclasses
import json

import numpy as np
import pytest
from gymnasium.spaces import Box, Discrete

from regista.experiments.commands.compare import _read
from regista.experiments.commands.train import _begin
from regista.experiments.run import build
from regista.experiments.run import config as configs
from regista.experiments.run.config import ConfigError, TrainConfig, presets
from regista.experiments.run.folder import RunFolder
from ued.config import PPOConfig
from ued.core.seeding import torch_generator
from ued.learning.student import Student


@pytest.mark.parametrize("name", ["fast", "thesis"])
def test_json_there_and_back(name, tmp_path):
    config = presets()[name]
    configs.save(config, tmp_path / "config.json")
    assert configs.load(TrainConfig, tmp_path / "config.json") == config


def test_thesis_is_table_4_2():
    config = presets()["thesis"]
    ppo = config.ppo
    assert (ppo.learning_rate, ppo.clip_coef, ppo.gamma, ppo.gae_lambda) == (8e-5, 0.27, 0.993, 0.95)
    assert (ppo.num_steps, ppo.num_minibatches, ppo.update_epochs, ppo.ent_coef, ppo.vf_coef) == (128, 8, 4, 0.01, 0.5)
    assert (config.paired.adversary.ent_coef, config.paired.adversary.update_epochs) == (0.01, 5)
    assert config.total_env_steps == 5_000_000 and config.num_envs == 16
    assert (config.paired.roles, config.paired.dr_fraction, config.paired.adversary.hidden_size) == (
        "dennis2020",
        0.0,
        512,
    )


def test_thesis_is_the_network_of_figure_4_10():
    start = build.find_game("1v1Restricted").start("thesis")
    assert (start.env.representation, start.env.rewards) == ("smm_stacked", "scoring")
    image, keys = Box(0, 255, (72, 96, 16), np.uint8), Discrete(19)
    student = Student(image, keys, start.ppo, torch_generator(0))
    assert sum(weight.numel() for weight in student.parameters()) == 750_228


@pytest.mark.parametrize("game", ["1v1Restricted", "academy/run_to_score", "1v1Free+Gauntlet"])
def test_thesis_is_the_same_in_every_command(game, tmp_path):
    """Also where a game is best paid otherwise: the thesis pays for goals."""
    start = build.find_game(game).start("thesis")
    run = _begin({"preset": "thesis", "config.minigame": game, "out": tmp_path / "run"})
    compared, _ = _read([game, "--preset", "thesis"])
    assert run.config.ppo == compared.train.ppo == start.ppo == PPOConfig.thesis()
    assert run.config.env == compared.train.env == start.env and start.env.rewards == "scoring"
    for name in ("ppo", "paired", "num_envs", "total_env_steps"):
        assert getattr(compared.train, name) == getattr(start, name) == getattr(run.config, name)


def changed(**changes):
    data = configs.to_dict(TrainConfig())
    for path, value in changes.items():
        *heads, last = path.split("__")
        place = data
        for head in heads:
            place = place[head]
        place[last] = value
    return data


@pytest.mark.parametrize(
    ("data", "sentence"),
    [
        (changed(ppo__gama=0.9), "c.json: unknown key 'ppo.gama' (did you mean 'gamma'?)"),
        (changed(num_envs="many"), "c.json: 'num_envs' must be int, got \"many\""),
        (changed(num_envs=True), "c.json: 'num_envs' must be int, got true"),
        (changed(lessons__plan="all"), "c.json: 'lessons.plan' must be a list, got \"all\""),  # JSON has no tuples
        (changed(ppo=3), "c.json: ppo must be an object, got 3"),
        (changed(num_envs=0), "c.json: num_envs must be at least 1, got 0"),
        ([], "c.json: the file must be an object, got []"),
    ],
)
def test_what_is_refused_and_how(data, sentence):
    with pytest.raises(ConfigError) as found:
        configs.from_dict(TrainConfig, data, "c.json")
    assert str(found.value) == sentence


def test_what_older_runs_know_nothing_of_is_what_they_did():
    data = configs.to_dict(TrainConfig())
    del data["ppo"]["team"], data["ppo"]["critic"], data["ppo"]["bptt_steps"], data["env"]["pixels"]
    for method in ("minimax", "paired", "paired_literal", "repaired", "self_regret"):
        del data[method]["adversary"]["builder"], data[method]["adversary"]["steps"]
    assert configs.from_dict(TrainConfig, data, "c.json") == TrainConfig()


def test_a_missing_key_is_named():
    data = configs.to_dict(TrainConfig())
    del data["ppo"]["gamma"]
    with pytest.raises(ConfigError, match=r"c.json: key 'ppo.gamma' is missing"):
        configs.from_dict(TrainConfig, data, "c.json")


def test_a_list_serves_as_tuple():
    assert configs.from_dict(TrainConfig, changed(lessons__plan=["all"]), "c.json").lessons.plan == ("all",)


def test_a_whole_number_serves_as_float():
    assert configs.from_dict(TrainConfig, changed(ppo__gamma=1), "c.json").ppo.gamma == 1.0


def test_what_is_no_json(tmp_path):
    (tmp_path / "config.json").write_text("{")
    with pytest.raises(ConfigError, match="is not JSON"):
        configs.load(TrainConfig, tmp_path / "config.json")


def test_differences_are_named_by_path():
    other = dataclasses.replace(TrainConfig(), seed=3, ppo=dataclasses.replace(TrainConfig().ppo, gamma=0.5))
    assert configs.differences(TrainConfig(), other) == {"seed": (0, 3), "ppo.gamma": (TrainConfig().ppo.gamma, 0.5)}


def test_every_setting_survives_json():
    assert json.loads(json.dumps(configs.to_dict(TrainConfig()))) == configs.to_dict(TrainConfig())


def test_no_file_says_what_is_to_be_run(tmp_path):
    env = dataclasses.replace(TrainConfig().env, engine="grf", grf_python="theirs/python")
    configs.save(dataclasses.replace(TrainConfig(), env=env), tmp_path / "config.json")
    found = configs.load(None, tmp_path / "config.json")
    assert found.env == dataclasses.replace(env, grf_python=None)


def test_what_is_to_be_run_is_told_to_the_processes_that_train(tmp_path):
    env = dataclasses.replace(TrainConfig().env, engine="grf", grf_python="/opt/ours/python")
    config = dataclasses.replace(TrainConfig(), env=env)
    for _ in range(2):  # a new one, and one that is there
        run = RunFolder.create_or_extend(tmp_path / "run", config)
        assert run.argv[-2:] == ["--grf-python", "/opt/ours/python"]
    assert RunFolder.open(tmp_path / "run").argv == ["train", "--resume", str(tmp_path / "run")]


def test_a_run_with_former_names_of_values_is_read(tmp_path):
    path = tmp_path / "config.json"
    config = TrainConfig()
    configs.save(config, path)
    older = path.read_text().replace('"distribution": "program"', '"distribution": "squashed"')
    path.write_text(older.replace('"roles": "population"', '"roles": "fixed"'))
    read = configs.load(None, path).paired
    assert (read.adversary.distribution, read.roles) == ("tanh_gaussian", "dennis2020")
