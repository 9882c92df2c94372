"""Adam over all weights at once is torch's fused Adam."""

import copy
import subprocess
import sys

import pytest
import torch
from torch import Tensor, nn

from ued.learning.fast_adam import Adam, clip_norm


def network() -> nn.Module:
    torch.manual_seed(0)
    return nn.Sequential(nn.Linear(5, 33), nn.Tanh(), nn.Linear(33, 3))


def trained(
    ours: bool, steps: int, state: dict | None = None, net: nn.Module | None = None
) -> tuple[nn.Module, dict, list[Tensor]]:
    """Take so many steps, those after `state`; return the network, the optimiser's state, and the norms."""
    net = net or network()
    adam = (
        Adam(net.parameters(), 0.01, 1e-5) if ours else torch.optim.Adam(net.parameters(), 0.01, eps=1e-5, fused=True)
    )
    if state is not None:
        adam.load_state_dict(copy.deepcopy(state))
    clip, norms = clip_norm if ours else nn.utils.clip_grad_norm_, []
    generator = torch.Generator().manual_seed(len(state["state"]) if state else 1)
    for _ in range(steps):
        x = torch.randn(16, 5, generator=generator)
        adam.zero_grad()
        ((net(x) - 3 * x[:, :3]) ** 2).mean().backward()
        norms.append(clip(net.parameters(), 0.5))
        adam.step()
    return net, adam.state_dict(), norms


def flat(net: nn.Module) -> Tensor:
    return torch.cat([weight.detach().flatten() for weight in net.parameters()])


@pytest.mark.slow
def test_steps_are_those_of_torch() -> None:
    (ours, state, norms), (theirs, other, wanted) = trained(True, 30), trained(False, 30)
    assert torch.equal(flat(ours), flat(theirs))
    assert torch.equal(torch.stack(norms), torch.stack(wanted))
    assert state["param_groups"] == other["param_groups"]
    for weight, known in other["state"].items():
        assert all(torch.equal(state["state"][weight][name], value) for name, value in known.items())


@pytest.mark.slow
@pytest.mark.parametrize("first", [True, False])
def test_either_goes_on_from_the_other(first: bool) -> None:
    net, state, _ = trained(first, 7)
    again, *_ = trained(not first, 7, state, net)
    straight, state, _ = trained(False, 7)
    wanted, *_ = trained(False, 7, state, straight)
    assert torch.equal(flat(again), flat(wanted))


def test_gradients_are_found_again_when_somebody_takes_them_away() -> None:
    net = network()
    adam = Adam(net.parameters(), 0.01, 1e-5)
    before = flat(net)
    for _ in range(2):
        net.zero_grad()  # sets them to None
        adam.zero_grad()
        net(torch.ones(1, 5)).sum().backward()
        adam.step()
        assert not torch.equal(flat(net), before)
        before = flat(net)


def test_the_gradient_is_cut_down_as_a_whole() -> None:
    ours, theirs = network(), network()
    adam = Adam(ours.parameters(), 0.01, 1e-5)
    for factor, max_norm in ((1.0, 0.5), (100.0, 0.5), (1.0, 1e6)):
        adam.zero_grad()
        theirs.zero_grad()
        for net in (ours, theirs):
            (factor * net(torch.ones(1, 5))).sum().backward()
        wanted = nn.utils.clip_grad_norm_(theirs.parameters(), max_norm)
        torch.testing.assert_close(adam.clip_norm(max_norm), wanted)
        for one, other in zip(ours.parameters(), theirs.parameters(), strict=True):
            torch.testing.assert_close(one.grad, other.grad)


def test_settings_come_from_no_checkpoint() -> None:
    weight = torch.nn.Parameter(torch.ones(2))
    optimizer = Adam([weight], 0.5, 1e-5)
    state = optimizer.state_dict()
    state["param_groups"] = [{"lr": float("nan"), "params": [0]}]
    optimizer.load_state_dict(state)
    optimizer.zero_grad()
    weight.sum().backward()
    optimizer.step()
    assert weight.tolist() == pytest.approx([0.5, 0.5], abs=1e-3)


def test_a_copy_goes_on_alone() -> None:
    net = network()
    adam = Adam(net.parameters(), 0.01, 1e-5)
    for _ in range(2):
        adam.zero_grad()
        net(torch.ones(1, 5)).sum().backward()
        adam.step()
        before = flat(net)
        net, adam = copy.deepcopy((net, adam))
        assert adam.weights[0] is net[0].weight and torch.equal(flat(net), before)


@pytest.mark.long
def test_no_optimizer_imports_the_compiler_of_torch():
    """The import would take a fifth of the processor time of a short run."""
    lines = (
        "import sys, torch",
        "from ued.learning.fast_adam import Adam",
        "weights = [torch.nn.Parameter(torch.ones(2))]",
        "optimizer = Adam(weights, 1e-3, 1e-5)",
        "optimizer.zero_grad()",
        "optimizer.step()",
        "optimizer.load_state_dict(optimizer.state_dict())",
        "assert 'torch._dynamo' not in sys.modules",
    )
    subprocess.run([sys.executable, "-c", "\n".join(lines)], check=True)
