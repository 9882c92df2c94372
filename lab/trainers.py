"""Trainers on one football game, measured in this process: Regista's DR, and PPO of other libraries.

    python -m lab.trainers '{"trainer": "sb3", "torso": "shared", "game": "1v1Rare", "num_envs": 16, "num_steps": 512,
                             "warm": 4, "seconds": 10}'

The program prints one line of JSON; CleanRL writes `runs/` to the current folder. All trainers play the same
environments, with a random level in each episode. All train a network of the same size with the game's PPO settings.
Rollouts and learning are each library's own code. CleanRL is a script that makes its environments from a module `gym`;
it gets a module with our vector environment. `lab.trainer_speed` runs this file once per measurement.
"""

from __future__ import annotations

import json
import os
import runpy
import sys
import time
import types
from contextlib import redirect_stdout, suppress
from dataclasses import dataclass, replace
from importlib import metadata, util
from itertools import pairwise
from typing import Any

import gymnasium
import numpy as np
import torch
from torch import nn
from torch.optim.optimizer import Optimizer, register_optimizer_step_post_hook

from regista.experiments.run import build

ENDLESS = 10**9  # environment steps of a training run that `Meter` ends
COMMON = "torch", "numpy", "gymnasium", "numba"  # packages of all trainers; numba compiles the simulator
PACKAGES = {
    "regista": (),
    "sb3": ("stable_baselines3",),
    "cleanrl": ("cleanrl", "stable_baselines3", "tensorboard"),  # it plays in the environments of `sb3`
    "pufferlib": ("pufferlib",),
}
# settings of PPO that have one name in Regista, CleanRL and PufferLib
SETTINGS = "learning_rate", "gamma", "gae_lambda", "update_epochs", "clip_coef", "vf_coef", "max_grad_norm", "ent_coef"


class Enough(Exception):
    """The measurement is over."""


class Meter:
    """Measures whole rounds: a rollout, and learning from it.

    Args:
        batch: environment steps of a rollout.
        warm: rounds before the measurement, at least 1.
        seconds: of processor time; the round that reaches them is the last one.

    Attributes:
        speed: environment steps per second of processor time.
        gradient_steps: of each round; counted before the measurement, since counting takes time.
        weights: number of trainable weights.
    """

    def __init__(self, batch: int, warm: int, seconds: float) -> None:
        self.batch, self.warm, self.seconds = batch, warm, seconds
        self.steps = self.rounds = self.weights = 0
        self.speed = self.began = self.gradient_steps = 0.0
        self._hook = register_optimizer_step_post_hook(self._count)

    def step(self, count: int) -> None:
        """Note that `count` environments are about to step. Raises Enough if the measurement is over."""
        if self.steps % self.batch == 0:
            self.begin_round()
        self.steps += count

    def begin_round(self) -> None:
        """Note that a round begins. Raises Enough if the measurement is over."""
        now = time.process_time()
        if self.rounds == self.warm:
            self.began = now
            self._hook.remove()
        elif self.rounds > self.warm and now - self.began >= self.seconds:
            self.speed = (self.rounds - self.warm) * self.batch / (now - self.began)
            raise Enough
        self.rounds += 1

    def note(self, gradient_steps: float, weights: int) -> None:
        """Note gradient steps of the rounds before the measurement."""
        if self.rounds <= self.warm:
            self.gradient_steps += gradient_steps / self.warm
            self.weights = weights

    def _count(self, optimizer: Optimizer, *arguments: Any) -> None:
        self.note(1, sum(weight.numel() for group in optimizer.param_groups for weight in group["params"]))


@dataclass(frozen=True)
class Job:
    """N new environments to train on, the settings of the run, and the meter of its rounds."""

    upomdp: Any
    config: Any
    meter: Meter


def main() -> None:
    """Measure what the argument describes, and print the measurement."""
    request = json.loads(sys.argv[1])
    torch.set_num_threads(1)
    job = make_job(request)
    with open(os.devnull, "w") as nowhere, redirect_stdout(nowhere), suppress(Enough):
        TRAINERS[request["trainer"]](job)
    found = {name: getattr(job.meter, name) for name in ("speed", "gradient_steps", "weights")}
    print(json.dumps(found | {"versions": versions(request["trainer"])}))


def missing(trainer: str) -> list[str]:
    """Return the packages of a trainer that are not installed."""
    return [name for name in PACKAGES[trainer] if util.find_spec(name) is None]


def versions(trainer: str) -> str:
    """Return the versions of Python and of the packages of a trainer."""
    python = ".".join(map(str, sys.version_info[:3]))
    return ", ".join([f"python {python}", *(f"{name} {metadata.version(name)}" for name in COMMON + PACKAGES[trainer])])


def make_job(request: dict[str, Any]) -> Job:
    """Make the environments and settings of a measurement: those of the game, except for the shape and the torsos."""
    game, num_envs = build.find_game(request["game"]), request["num_envs"]
    config = game.start("fast")
    ppo = replace(config.ppo, num_steps=request["num_steps"], shared_torso=request["torso"] == "shared")
    config = replace(config, method="dr", minigame=request["game"], num_envs=num_envs, ppo=ppo, seed=1)
    upomdp = build.make_upomdp(game.task(config).make, num_envs, config.seed)
    return Job(upomdp, config, Meter(num_envs * ppo.num_steps, request["warm"], request["seconds"]))


def train_regista(job: Job) -> None:
    """Train with domain randomization, each episode on a random level."""
    made = build.make_method(job.config, job.upomdp)
    weights = sum(map(torch.numel, made.student.parameters()))
    while True:
        job.meter.begin_round()
        job.meter.note(made.update()["student/gradient_steps"], weights)


def torso(job: Job) -> nn.Sequential:
    """Return hidden layers of the same size as Regista's."""
    sizes = [job.upomdp.single_observation_space.shape[0]] + [job.config.ppo.hidden_size] * job.config.ppo.hidden_layers
    return nn.Sequential(*(layer for pair in pairwise(sizes) for layer in (nn.Linear(*pair), nn.Tanh())))


def metered(job: Job) -> Any:
    """Return the environments as Stable-Baselines3's `VecEnv`; the meter counts their steps.

    Resets and steps have the return values of Gym's vector environments before version 0.26.
    """
    from ued.adapters.sb3 import SB3VecEnv

    class MeteredVecEnv(SB3VecEnv):
        single_observation_space = job.upomdp.single_observation_space
        single_action_space = job.upomdp.single_action_space

        def step_wait(self) -> Any:
            job.meter.step(self.num_envs)
            return super().step_wait()

    return MeteredVecEnv(job.upomdp)


def train_sb3(job: Job) -> None:
    """Train with Stable-Baselines3's PPO. A shared torso for actor and critic is its features extractor."""
    from stable_baselines3 import PPO
    from stable_baselines3.common.torch_layers import BaseFeaturesExtractor

    ppo = job.config.ppo

    class Torso(BaseFeaturesExtractor):
        def __init__(self, space: gymnasium.Space) -> None:
            super().__init__(space, ppo.hidden_size)
            self.layers = torso(job)

        def forward(self, observation: torch.Tensor) -> torch.Tensor:
            return self.layers(observation)

    shared = {"features_extractor_class": Torso, "net_arch": []}
    separate = {"net_arch": [ppo.hidden_size] * ppo.hidden_layers}
    PPO(
        "MlpPolicy",
        metered(job),
        learning_rate=ppo.learning_rate,
        n_steps=ppo.num_steps,
        batch_size=job.meter.batch // ppo.num_minibatches,
        n_epochs=ppo.update_epochs,
        gamma=ppo.gamma,
        gae_lambda=ppo.gae_lambda,
        clip_range=ppo.clip_coef,
        normalize_advantage=ppo.norm_adv,
        ent_coef=ppo.ent_coef,
        vf_coef=ppo.vf_coef,
        max_grad_norm=ppo.max_grad_norm,
        policy_kwargs=shared if ppo.shared_torso else separate,
        seed=job.config.seed,
        device="cpu",
    ).learn(ENDLESS)


def train_cleanrl(job: Job) -> None:
    """Run CleanRL's PPO script, whose network is fixed: two layers of 64 units each for actor and critic."""
    ppo, gym = job.config.ppo, types.ModuleType("gym")
    if (ppo.shared_torso, ppo.hidden_size, ppo.hidden_layers) != (False, 64, 2):
        raise ValueError(f"CleanRL's script trains separate torsos of 2 layers of 64 units, not those of {ppo}")
    vector = types.SimpleNamespace(SyncVectorEnv=lambda makers: metered(job))
    gym.__dict__.update(spaces=gymnasium.spaces, vector=vector)
    sys.modules["gym"] = gym
    names = *SETTINGS, "num_steps", "num_minibatches", "clip_vloss", "norm_adv"
    chosen = {name: getattr(ppo, name) for name in names}
    chosen |= {"num_envs": job.upomdp.num_envs, "total_timesteps": ENDLESS, "cuda": False, "anneal_lr": False}
    sys.argv[1:] = [f"--{name.replace('_', '-')}={value}" for name, value in chosen.items()]
    runpy.run_module("cleanrl.ppo", run_name="__main__", alter_sys=True)


def train_pufferlib(job: Job) -> None:
    """Train with PufferLib's `PuffeRL` without its display, with our environments as its native ones."""
    from pufferlib.pufferl import PuffeRL

    trainer = PuffeRL(puffer_settings(job), puffer_env(job), PufferPolicy(job))
    trainer.print_dashboard = lambda *arguments, **named: None
    try:
        while True:
            job.meter.begin_round()
            trainer.evaluate()
            trainer.train()
    finally:
        trainer.utilization.stop()


def puffer_settings(job: Job) -> dict[str, Any]:
    """Return the settings of `PuffeRL`: its defaults, except for those that the game specifies."""
    ppo, batch = job.config.ppo, job.meter.batch
    names = (*SETTINGS, "adam_eps")
    shape = {"batch_size": batch, "bptt_horizon": ppo.num_steps, "minibatch_size": batch // ppo.num_minibatches}
    adam = {"optimizer": "adam", "adam_beta1": 0.9, "adam_beta2": 0.999, "anneal_lr": False}
    defaults = {"vf_clip_coef": 0.2, "vtrace_rho_clip": 1.0, "vtrace_c_clip": 1.0, "prio_alpha": 0.8, "prio_beta0": 0.2}
    machine = {"device": "cpu", "cpu_offload": False, "precision": "float32", "compile": False, "use_rnn": False}
    run = {"env": "regista", "seed": job.config.seed, "torch_deterministic": True, "data_dir": "."}
    run |= {"total_timesteps": ENDLESS, "checkpoint_interval": ENDLESS, "max_minibatch_size": batch}
    return {name: getattr(ppo, name) for name in names} | shape | adam | defaults | machine | run


def puffer_env(job: Job) -> Any:
    """Return the environments as one PufferLib environment, with one agent for each of them."""
    from pufferlib import PufferEnv

    upomdp = job.upomdp

    class VectorEnv(PufferEnv):
        single_observation_space = upomdp.single_observation_space
        single_action_space = upomdp.single_action_space
        num_agents = upomdp.num_envs

        def reset(self, seed: int | None = None) -> tuple[np.ndarray, list]:
            upomdp.level_sampler = upomdp.sample_levels
            self.observations[:] = upomdp.reset(seed=seed)[0]
            return self.observations, []

        def step(self, actions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, list]:
            self.observations[:], self.rewards[:], self.terminals[:], self.truncations[:], _ = upomdp.step(actions)
            return self.observations, self.rewards, self.terminals, self.truncations, []

        def close(self) -> None:
            upomdp.close()

    return VectorEnv()


class PufferPolicy(nn.Module):
    """A policy and a value on one or two torsos, in the form that PufferLib expects."""

    def __init__(self, job: Job) -> None:
        super().__init__()
        self.actor_torso = torso(job)
        self.critic_torso = self.actor_torso if job.config.ppo.shared_torso else torso(job)
        self.actor = nn.Linear(job.config.ppo.hidden_size, int(job.upomdp.single_action_space.n))
        self.critic = nn.Linear(job.config.ppo.hidden_size, 1)

    def forward(self, observation: torch.Tensor, state: Any = None) -> tuple[torch.Tensor, torch.Tensor]:
        """Return the logits `[B, A]` and values `[B, 1]` of observations `[B, size]`."""
        seen = self.actor_torso(observation)
        judged = seen if self.critic_torso is self.actor_torso else self.critic_torso(observation)
        return self.actor(seen), self.critic(judged)

    forward_eval = forward


TRAINERS = {"regista": train_regista, "sb3": train_sb3, "cleanrl": train_cleanrl, "pufferlib": train_pufferlib}

if __name__ == "__main__":
    main()
