"""A user network as the first layers of actor and critic, by name: `PPOConfig(network="my_nets.py:Net")`.

The built-in memory and heads follow. Read next: `learning.networks`, the built-in networks; `learning.student`.
"""

from __future__ import annotations

import torch
from gymnasium.spaces import Space
from torch import Tensor, nn

from ued.config import PPOConfig
from ued.core.own_code import OwnCodeError, load
from ued.learning.networks import ONE_AGENT, Team, Torso

ROWS = 2  # rows of the batch that tests a new network
MOODY = (nn.modules.dropout._DropoutNd, nn.modules.batchnorm._BatchNorm)  # differ between training and playing


class _Rows(nn.Module):
    """Treats agents as additional rows: `[B, A, ...]` -> `[B, A, size]`."""

    def __init__(self, network: nn.Module) -> None:
        super().__init__()
        self.network = network

    def forward(self, seen: Tensor) -> Tensor:
        return self.network(seen.flatten(0, 1)).unflatten(0, seen.shape[:2])


def own_torso(space: Space, config: PPOConfig, generator: torch.Generator, team: Team = ONE_AGENT) -> Torso:
    """Return the network that `config.network` names, made by `Net(space, config)`: `[B, ...]` -> `[B, size]`.

    Its weights are initialized from torch's global generator, temporarily seeded from `generator`. Raises
    `OwnCodeError` unless it is a module with this output, and for several agents with separate policies.
    """
    name = config.network
    if team.policies > 1:
        raise OwnCodeError(f"the network {name} supports one policy: several agents need team='shared' (--team shared)")
    made = load(name)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(int(torch.randint(2**62, (1,), generator=generator)))
        try:
            network = made(space, config)
        except Exception as error:  # user code can raise any error
            raise OwnCodeError(f"{name}(space, config) failed: {type(error).__name__}: {error}") from error
        if not isinstance(network, nn.Module):
            raise OwnCodeError(f"{name}(space, config) must return a torch.nn.Module, got {network!r:.100}")
        size = _size(name, network, space)
    moody = next((part for part in network.modules() if isinstance(part, MOODY)), None)
    if moody is not None:
        raise OwnCodeError(
            f"{name} has a {type(moody).__name__}: PPO needs equal probabilities in rollouts and updates; "
            "use LayerNorm instead, or remove it"
        )
    return Torso([network if team.agents == 1 else _Rows(network)], size)


def _size(name: str, network: nn.Module, space: Space) -> int:
    """Return the number of features of a network. Raises `OwnCodeError` unless it maps `[B, ...]` to `[B, size]`."""
    shape = space.shape or ()
    try:
        with torch.no_grad():
            features = network(torch.zeros(ROWS, *shape))
    except Exception as error:  # user code can raise any error
        seen = ", ".join(map(str, ("B", *shape)))
        raise OwnCodeError(f"{name} failed on observations [{seen}]: {type(error).__name__}: {error}") from error
    if (
        not isinstance(features, Tensor)
        or features.ndim != 2
        or len(features) != ROWS
        or not features.is_floating_point()
    ):
        got = f"{list(features.shape)} of {features.dtype}" if isinstance(features, Tensor) else f"{features!r:.100}"
        raise OwnCodeError(f"{name} must return features of floats, [B, size] for B observations; for {ROWS} got {got}")
    return features.shape[1]
