"""A user network as the first layers of actor and critic, by name: `PPOConfig(network="my_nets.py:Net")`.

A network that PPO could not learn with is rejected before training: see `rehearsed`. The built-in memory and heads
follow. Read next: `learning.networks`, the built-in networks; `learning.student`.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping

import torch
from gymnasium.spaces import Space
from torch import Tensor, nn

from ued.config import PPOConfig
from ued.core.own_code import FAILURES, OwnCodeError, load
from ued.learning.networks import ONE_AGENT, Team, Torso

ROWS = 4  # rows of the batch that tests a new network
TOLERANCE = 1e-4  # of the largest feature: a sum over a batch of another size is rounded otherwise
ROUNDING = 1e-6  # of an observation, 8 times float32's precision: sin(100 x) also rounds more than other functions
EQUAL = "PPO needs equal probabilities in rollouts and updates"


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
    `OwnCodeError` as `rehearsed`, and for several agents with separate policies.
    """
    name = config.network
    if team.policies > 1:
        raise OwnCodeError(f"the network {name} supports one policy: several agents need team='shared' (--team shared)")
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed := int(torch.randint(2**62, (1,), generator=generator)))
        network = _made(name, space, config)
        size = rehearsed(name, network, space)
        torch.manual_seed(seed + 1)
        _check_saved(name, network, _made(name, space, config), space)
    return Torso([network if team.agents == 1 else _Rows(network)], size)


def _made(name: str, space: Space, config: PPOConfig) -> nn.Module:
    make = load(name)
    try:
        network = make(space, config)
    except FAILURES as error:
        raise OwnCodeError(f"{name}(space, config) failed: {type(error).__name__}: {error}") from error
    if not isinstance(network, nn.Module):
        raise OwnCodeError(f"{name}(space, config) must return a torch.nn.Module, got {network!r:.100}")
    return network


def rehearsed(name: str, network: nn.Module, space: Space) -> int:
    """Return the number of features of a network, after it was tested on random observations in [0, 1).

    Raises `OwnCodeError` unless it maps float32 `[B, ...]` to float32 `[B, size]`, always in the same way, each row
    separately, and with gradients; it warns of weights without any.
    """
    seen = _observations(space)
    features = _features(name, network, seen)  # the first call, which also makes lazy layers
    _check_weights(name, network, features)
    _check_constant(name, network, seen, features)
    with torch.no_grad():  # the last calls: a module that keeps its features can be copied
        rounding = (_features(name, network, seen * (1 + ROUNDING)) - features).abs()
    for part in (slice(0, 1), slice(ROWS - 1, ROWS), slice(0, ROWS // 2), slice(ROWS // 2, ROWS)):
        with torch.no_grad():
            alone = _features(name, network, seen[part])
        if not _close(alone, features[part], rounding.max()):
            raise OwnCodeError(
                f"{name} mixes the rows of a batch: the features of an observation depend on the others. {EQUAL}, in "
                "batches of any size; use each row alone, for example LayerNorm instead of BatchNorm"
            )
    return features.shape[1]


def _observations(space: Space) -> Tensor:
    return torch.rand(ROWS, *(space.shape or ()), generator=torch.Generator().manual_seed(0))


def _check_saved(name: str, network: nn.Module, other: nn.Module, space: Space) -> None:
    """Raise `OwnCodeError` unless another instance with the weights of the first has its features, as after loading."""
    seen = _observations(space)
    with torch.no_grad():
        features, _ = _features(name, network, seen), _features(name, other, seen)  # the call makes lazy layers
        try:
            other.load_state_dict(network.state_dict())
        except RuntimeError as error:
            raise OwnCodeError(f"{name}(space, config) made two networks of different weights: {error}") from error
        if not _close(_features(name, other, seen), features):
            raise OwnCodeError(
                f"{name} has values that are not saved with its weights and differ between two instances, so a loaded "
                "policy would act differently; register them with register_buffer, or give them a fixed seed"
            )


def _features(name: str, network: nn.Module, seen: Tensor) -> Tensor:
    """Return the features `[B, size]` of observations `[B, ...]`, which must stay unchanged."""
    given = seen.clone()
    try:
        features = network(given)
    except FAILURES as error:
        shape = ", ".join(map(str, ("B", *seen.shape[1:])))
        raise OwnCodeError(
            f"{name} failed on float32 observations [{shape}]: {type(error).__name__}: {error}"
        ) from error
    fits = isinstance(features, Tensor) and features.ndim == 2 and len(features) == len(seen) and features.numel() > 0
    if not fits or features.dtype != torch.float32:
        got = f"{list(features.shape)} of {features.dtype}" if isinstance(features, Tensor) else f"{features!r:.100}"
        raise OwnCodeError(
            f"{name} must return float32 features, [B, size] for B observations; for {len(seen)} got {got}"
        )
    if not features.isfinite().all():
        raise OwnCodeError(f"{name} returned NaN or infinity for observations in [0, 1)")
    if not torch.equal(given, seen):
        raise OwnCodeError(f"{name} changes its observations in place; make new ones, x = x / 2 instead of x /= 2")
    return features


def _check_constant(name: str, network: nn.Module, seen: Tensor, features: Tensor) -> None:
    """Raise `OwnCodeError` if another call has other features, draws random numbers or changes the network."""
    stream, before = torch.get_rng_state(), _state(network)
    with torch.no_grad():
        again = _features(name, network, seen)
    if not torch.equal(stream, torch.get_rng_state()):
        raise OwnCodeError(f"{name} draws random numbers in forward, as dropout does: {EQUAL}; remove dropout")
    changed = _changed(before, _state(network))
    if changed is not None:
        raise OwnCodeError(
            f"{name} changes its {changed} in forward, as batch and spectral normalization do: {EQUAL}; "
            "use LayerNorm or nn.utils.parametrizations.weight_norm instead, or keep such values in local variables"
        )
    if not _close(again, features):
        raise OwnCodeError(
            f"{name} returns other features when it is called again on the same observations: {EQUAL}; keep no state, "
            "and draw no random numbers in forward (for memory within an episode: --memory gru)"
        )


def _state(network: nn.Module) -> dict[str, tuple[Tensor, int]]:
    """Return all weights and buffers of a network, and how often each was written."""
    return {key: (value, value._version) for key, value in (*network.named_parameters(), *network.named_buffers())}


def _changed(before: Mapping[str, tuple[Tensor, int]], after: Mapping[str, tuple[Tensor, int]]) -> str | None:
    """Return the first name that was replaced by other values, or written, even with equal ones.

    Spectral normalization, which converges, would write equal values before training and others during it.
    """
    for key, (old, writes) in before.items():
        new, now = after.get(key, (None, 0))
        if new is None or (writes != now if new is old else not torch.equal(old, new)):
            return key
    return None


def _close(one: Tensor, other: Tensor, rounding: Tensor | float = 0.0) -> bool:
    """Return whether features are equal up to rounding; `rounding` is their change by small changes of the input."""
    if one.shape != other.shape:
        return False
    return bool((one - other).abs().max() <= max(TOLERANCE * other.abs().max(), rounding))


def _check_weights(name: str, network: nn.Module, features: Tensor) -> None:
    """Raise `OwnCodeError` unless all weights are float32, and those of the module are those that learn."""
    own = {weight: key for key, weight in network.named_parameters()}
    for weight, key in own.items():
        if weight.dtype != torch.float32:
            raise OwnCodeError(f"{name} must have float32 weights, but its {key} is {weight.dtype}")
    reached = _leaves(features)
    if reached - own.keys():
        raise OwnCodeError(
            f"{name} uses weights that are not registered, so PPO would neither train nor save them; "
            "hold weights in nn.Parameter attributes, nn.ParameterList or nn.ModuleList, not in lists"
        )
    apart = [key for weight, key in own.items() if weight.requires_grad and weight not in reached]
    if apart:
        said = (
            f"no gradient reaches {', '.join(apart[:3])}{', …' * (len(apart) > 3)} of {name}: for these observations "
            "forward does not use it, or computes it under torch.no_grad or detach"
        )
        if not reached:
            raise OwnCodeError(said)
        warnings.warn(f"{said}; it may be meant, as in a mixture of experts", stacklevel=2)
    try:
        torch.autograd.grad(features.sum(), list(reached)) if reached else ()
    except FAILURES as error:
        raise OwnCodeError(f"{name} has no gradient: {type(error).__name__}: {error}") from error


def _leaves(features: Tensor) -> set[Tensor]:
    """Return the weights from which features were computed with gradients."""
    found, known, open_nodes = set(), set(), [features.grad_fn]
    while open_nodes:
        node = open_nodes.pop()
        if node is None or node in known:
            continue
        known.add(node)
        if hasattr(node, "variable"):
            found.add(node.variable)
        open_nodes += [following for following, _ in node.next_functions]
    return found
