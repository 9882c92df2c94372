"""A team trained with TorchRL: MAPPO on a minigame as a PettingZoo environment.

    pip install 'regista[pettingzoo]' torchrl
    python examples/with_torchrl.py --env-steps 200000

It plays one match at a time and serves as an example of the interface, not of speed. `regista train --control closest2
--critic central` does the same on a native batch, a hundred times faster, with every curriculum.
"""

import argparse

import torch
from tensordict.nn import TensorDictModule
from torch.distributions import Categorical
from torchrl.envs import RewardSum, TransformedEnv
from torchrl.envs.libs.pettingzoo import PettingZooWrapper
from torchrl.modules import MultiAgentMLP, ProbabilisticActor
from torchrl.objectives import ClipPPOLoss, ValueEstimators

from regista import minigames

ACTIONS, STEPS, EPOCHS, MINIBATCHES = 19, 512, 4, 4
TEAM = "agent"  # TorchRL groups agents by their names up to the number


def make_env(game, control):
    """Make a match whose agents move the players of `control`, with a running sum of rewards."""
    match = minigames.parallel_env(game, control=control)
    env = PettingZooWrapper(match, categorical_actions=True, use_mask=False)
    return TransformedEnv(env, RewardSum([env.reward_key], [(TEAM, "episode_reward")]))


def make_networks(env):
    """Make a policy that all agents share, with local observations, and a critic that observes all of them."""
    agents, features = env.observation_spec[TEAM, "observation"].shape[-2:]
    shape = {"n_agent_inputs": features, "n_agents": agents, "share_params": True, "depth": 2, "num_cells": 64}
    policy = MultiAgentMLP(n_agent_outputs=ACTIONS, centralized=False, **shape)
    value = MultiAgentMLP(n_agent_outputs=1, centralized=True, **shape)
    actor = ProbabilisticActor(
        TensorDictModule(policy, [(TEAM, "observation")], [(TEAM, "logits")]),
        spec=env.action_spec,
        in_keys=[(TEAM, "logits")],
        out_keys=[env.action_key],
        distribution_class=Categorical,
        return_log_prob=True,
    )
    return actor, TensorDictModule(value, [(TEAM, "observation")], [(TEAM, "state_value")])


def make_loss(env, actor, critic):
    """Make PPO's clipped loss, with the keys of the team's data."""
    normalized = {"normalize_advantage": True, "normalize_advantage_exclude_dims": (1,)}  # each agent's own
    loss = ClipPPOLoss(actor, critic, clip_epsilon=0.2, entropy_coeff=0.01, **normalized)
    loss.set_keys(
        reward=env.reward_key,
        action=env.action_key,
        value=(TEAM, "state_value"),
        done=(TEAM, "done"),
        terminated=(TEAM, "terminated"),
    )
    loss.make_value_estimator(ValueEstimators.GAE, gamma=0.995, lmbda=0.95)
    return loss


def learn(loss, optimizer, batch):
    """Update on the steps `[T]` of a rollout for several epochs, in minibatches."""
    with torch.no_grad():
        loss.value_estimator(batch, params=loss.critic_network_params, target_params=loss.target_critic_network_params)
    for _ in range(EPOCHS):
        for rows in torch.randperm(len(batch)).chunk(MINIBATCHES):
            losses = loss(batch[rows])
            optimizer.zero_grad()
            sum(losses[name] for name in ("loss_objective", "loss_critic", "loss_entropy")).backward()
            torch.nn.utils.clip_grad_norm_(loss.parameters(), 0.5)
            optimizer.step()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--game", default="3v2FourBehaviors", help="a minigame's name")
    parser.add_argument("--control", default="closest2", help="players that the agents move")
    parser.add_argument("--env-steps", type=int, default=200_000, help="steps to train for")
    arguments = parser.parse_args()
    torch.manual_seed(0)
    env = make_env(arguments.game, arguments.control)
    env.set_seed(0)
    actor, critic = make_networks(env)
    loss = make_loss(env, actor, critic)
    optimizer = torch.optim.Adam(loss.parameters(), 3e-4)
    for steps in range(STEPS, arguments.env_steps + 1, STEPS):
        with torch.no_grad():
            batch = env.rollout(STEPS, actor, break_when_any_done=False)
        learn(loss, optimizer, batch)
        after = batch["next"]
        returns = after[TEAM, "episode_reward"][after[TEAM, "done"]]
        print(f"{steps} env_steps, {after['done'].sum()} episodes, mean return {returns.mean():+.2f}")


if __name__ == "__main__":
    main()
