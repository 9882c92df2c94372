"""DCD's network on mazes: their vectors declare an image and a direction, which `network = "cnn"` finds."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from test_maze import FIVE, OPAQUE, trained

from regista.envs.maze.config import MazeConfig
from regista.envs.maze.env import Mazes
from regista.experiments.__main__ import main
from ued import load_policy
from ued.config import PPOConfig
from ued.core.parts import Parts
from ued.core.seeding import torch_generator
from ued.learning.student import Student
from ued.methods import METHODS

DCD = PPOConfig(network="cnn", memory="gru", hidden_layers=0, hidden_size=256, head_size=32, shared_torso=True)
QUICK = replace(DCD, num_steps=16, num_minibatches=2, update_epochs=1, hidden_size=12)


@pytest.mark.parametrize("see_through", [True, False])
@pytest.mark.parametrize("representation", ["features", "image"])
def test_the_image_of_an_observation_is_minigrids(representation, see_through):
    mazes = Mazes(40, MazeConfig(side=5, num_walls=8, representation=representation, see_through=see_through))
    seen, _ = mazes.reset(seed=1)
    space, codes = mazes.single_observation_space, mazes.images()  # [N, 5, 5, 3]: object, color, state
    image = torch.as_tensor(seen[:, space.images[0].first : space.images[0].last]).unflatten(1, space.images[0].image)
    np.testing.assert_array_equal(seen[:, -4:].argmax(1), mazes.directions())
    if representation == "image":
        np.testing.assert_array_equal(image, codes / np.float32(10))
    else:  # MiniGrid's objects: 0 unseen, 2 wall, 8 goal
        planes = [codes[..., 0] == 2, codes[..., 0] == 8, codes[..., 0] != 0][: 2 if see_through else 3]
        np.testing.assert_array_equal(image, np.stack(planes, 1))
        assert all(plane.any() for plane in planes)


@pytest.mark.slow
def test_it_is_dcds_network_but_for_the_lstm_and_the_layer_of_the_direction():
    mazes = Mazes(2, MazeConfig(representation="image"))
    student = Student(mazes.single_observation_space, mazes.single_action_space, DCD, torch_generator(0))
    shapes = {name: tuple(weight.shape) for name, weight in student.named_parameters() if name.endswith("weight")}
    assert shapes == {
        "actor_torso.0.read.0.1.weight": (16, 3, 3, 3),
        "actor_memory.read.weight": (3 * 256, 16 * 9 + 4),
        "actor_memory.recall.weight": (3 * 256, 256),
        "actor_hidden.0.weight": (32, 256),
        "critic_hidden.0.weight": (32, 256),
        "actor.layer.weight": (3, 32),
        "critic.weight": (1, 32),
    }


def test_without_the_setting_mazes_are_seen_by_an_mlp():
    space = Mazes(2).single_observation_space
    student = Student(space, Mazes(2).single_action_space, PPOConfig(), torch_generator(0))
    assert isinstance(space, Parts) and not any(isinstance(m, torch.nn.Conv2d) for m in student.modules())


@pytest.mark.slow
@pytest.mark.parametrize("method_name", ["dr", "plr", "paired"])
def test_it_trains_and_goes_on_bit_for_bit(method_name):
    def method():
        return METHODS[method_name].load()(Mazes(4, FIVE), QUICK, None, seed=3, env_steps=1000)

    one, twin = method(), method()
    one.update()
    twin.load_state_dict(one.state_dict())
    for _ in range(2):
        metrics, others = one.update(), twin.update()
        assert not any(learner.worker.is_compiled for learner in one.learners)
        for name, value in metrics.items():
            assert name.startswith("time/") or others[name] == pytest.approx(value, rel=0, abs=0, nan_ok=True), name


@pytest.mark.slow
@pytest.mark.parametrize("settings", [{"hidden_layers": 0}, {"head_size": 9}, {"hidden_layers": 0, "head_size": 9}])
@pytest.mark.parametrize("memory", ["gru", "none"])
def test_a_compiled_rollout_has_these_layers_too(memory, settings, monkeypatch):
    """Without convolutions; seven units, so that inputs and state of the GRU have different sizes."""
    ppo = PPOConfig(num_steps=32, num_minibatches=2, update_epochs=1, memory=memory, hidden_size=7, **settings)
    case = "dr", 5, ppo, OPAQUE
    (_, ours), (_, theirs) = (trained(case, compiled, monkeypatch, updates=2) for compiled in (True, False))
    for (rollouts, *_), (others, *_) in zip(ours, theirs, strict=True):
        for rollout, single in zip(rollouts, others, strict=True):
            assert torch.equal(rollout["action"], single["action"])
            for name in ("log_prob", "value", "final_value", "last_value"):
                torch.testing.assert_close(rollout[name], single[name], atol=1e-5, rtol=0, msg=name)


def test_heads_behind_a_shared_torso_are_played_step_by_step():
    ppo = PPOConfig(num_steps=8, num_minibatches=1, shared_torso=True, head_size=9, hidden_size=8)
    method = METHODS["dr"].load()(Mazes(4, FIVE), ppo, None, seed=0, env_steps=1000)
    assert not method.learners[0].worker.is_compiled
    assert method.update()["env_steps"] == 32


@pytest.mark.slow
def test_the_command_line_trains_resumes_and_its_policy_is_loaded(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    out, steps = str(tmp_path / "run"), ["--num-envs", "4", "--num-steps", "16", "--eval-every", "0", "--no-record"]
    network = ["--network", "cnn", "--hidden-layers", "0", "--hidden-size", "16", "--head-size", "8"]
    assert main(["train", "maze", *steps, *network, "--method", "plr", "--total-env-steps", "128", "--out", out]) == 0
    assert main(["train", "--resume", out, "--total-env-steps", "192"]) == 0
    policy, mazes = load_policy(out), Mazes(3)
    seen, _ = mazes.reset(seed=0)
    assert isinstance(policy.observation_space, Parts) and policy.observation_space.network == "mlp"
    assert any(isinstance(layer, torch.nn.Conv2d) for layer in policy.student.modules())
    assert policy.act(seen).shape == (3,)
