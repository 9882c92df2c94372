"""The adversary's distribution over θ: initially that of the program, but flexible enough for any region.

    h = tanh(W z + c)                                       z: a random vector, or a context
    choice_j ~ softmax(log weights_j + A_j h_j)             in sequence: h_j also depends on choices before j
    real_d   ~ sum over k of share_dk · bump(mean_dk, scale_dk)     in parallel, given z and all choices

A choice is a column with a few values: `Uniform`, `Discrete`, an integer, the program of a mixture. Its categorical
distribution is initialized with the program's weights, so the position of an option in the list does not matter. A
real number has COMPONENTS bumps: logistic distributions truncated to [-1, 1], whose sum is initially nearly uniform.
The shares can move mass to a distant bump directly, and the distribution can stay multimodal. A_j and the output
weights for shares, means and scales are initialized with 0.

Log-densities are relative to the program's: log pi(θ) / pi_0(θ), where pi_0 is domain randomization, uniform in θ. So
they are initially 0, and their negative mean is -KL(pi, pi_0) ≤ 0 for every kind of column.
Read next: `levels.adversary`, which trains it; `levels.unimodal`, the Gaussian of the thesis as an alternative.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor, nn

from ued.core.cells import Cells
from ued.core.parameters import Parameter, choice_in
from ued.learning.networks import IMPOSSIBLE, linear

# The initial bumps of each real number: symmetric, and in sum uniform within a few percent.
FIRST_MEANS = (-0.98, -0.49, 0.0, 0.49, 0.98)
FIRST_SHARES = (0.7, 1.0, 1.0, 1.0, 0.7)  # unnormalized
FIRST_SCALE = 0.2
COMPONENTS = len(FIRST_MEANS)
MOST_MEAN = 1.05  # limit of the absolute value of a mean
LOG_SCALE_RANGE = (math.log(0.01), math.log(3.0))  # from 2% of [-1, 1] to all of it
WIDE = 64  # choices with more values are padded separately
SMALL = 1e-9  # minimum density, to keep its logarithm finite


class Drawn(NamedTuple):
    """A sampled column: its index in θ, its program in a mixture (-1: all), and its cells, if discrete."""

    column: int
    program: int
    cells: Cells | None


class Group(NamedTuple):
    """Choices that are padded to the same number of values.

    Attributes:
        at: `[n]` indices among all choices.
        log_weights: `[n, most values]` of the program.
        logits: `[n, most values, H]` A.
        seen: `[n, most values, H]` contribution of a choice to later h.
    """

    at: Tensor
    log_weights: Tensor
    logits: Tensor
    seen: Tensor


def _within(raw: Tensor, group: Group) -> Tensor:
    """Return the indices of values; in rows of other programs they are clamped and not used."""
    return raw.long().clamp(0, group.seen.shape[1] - 1)


def layout(draws: Sequence[Parameter], program_parameters: Sequence[Sequence[Parameter]] = ()) -> list[Drawn]:
    """Return the sampled columns of θ; for a mixture, column 0 and then the columns of each program."""
    if not program_parameters:
        return [Drawn(column, -1, choice_in(draw)) for column, draw in enumerate(draws)]
    drawn = [Drawn(0, -1, choice_in(draws[0]))]
    for program, own in enumerate(program_parameters):
        drawn += [Drawn(column, program, choice_in(draw)) for column, draw in enumerate(own, 1)]
    return drawn


class ThetaDistribution(nn.Module):
    """z `[B, Z]` -> a distribution over θ for each row, and the expected score.

    A sample `raw` `[B, D]` holds θ itself for real columns and the index of the value for choices. It is 0 in columns
    that the chosen program of a mixture does not have.

    Args:
        draws, program_parameters: the columns of θ, see `layout`.
        context_size: Z.
        hidden: units of each of the two layers.
        generator: random generator of the initial weights.
    """

    def __init__(
        self,
        draws: Sequence[Parameter],
        program_parameters: Sequence[Sequence[Parameter]],
        context_size: int,
        hidden: int,
        generator: torch.Generator,
    ) -> None:
        super().__init__()
        drawn = layout(draws, program_parameters)
        self.dim, self.mixed = len(draws), bool(program_parameters)
        self.choices = [part for part in drawn if part.cells is not None]
        self.reals = [part for part in drawn if part.cells is None]
        (self.choice_at, self.choice_of), (self.real_at, self.real_of) = map(_places, (self.choices, self.reals))
        self.narrow, self.wide = _by_width(self.choices)
        self.log_weights = _log_weights([self.choices[j] for j in self.narrow])
        self.first, self.second = (linear(size, hidden, math.sqrt(2), generator) for size in (context_size, hidden))
        self.value = linear(hidden, 1, 0.0, generator)
        self.logits = nn.Parameter(torch.zeros(*self.log_weights.shape, hidden))  # A
        self.seen = nn.Parameter(torch.zeros(*self.log_weights.shape, hidden))
        if len(self.wide):
            self.wide_log_weights = _log_weights([self.choices[j] for j in self.wide])
            self.wide_logits = nn.Parameter(torch.zeros(*self.wide_log_weights.shape, hidden))
            self.wide_seen = nn.Parameter(torch.zeros(*self.wide_log_weights.shape, hidden))
        self.in_order = torch.argsort(torch.cat([self.narrow, self.wide]))
        self.place = {int(j): (g, i) for g, group in enumerate(self._groups()) for i, j in enumerate(group.at)}
        self.bumps = linear(hidden, 3 * len(self.reals) * COMPONENTS, 0.0, generator) if self.reals else None
        self.first_shares = torch.tensor(FIRST_SHARES).log()
        self.first_means = torch.atanh(torch.tensor(FIRST_MEANS) / MOST_MEAN)

    # ------------------------------------------------------------ sampling and densities

    def sample(self, z: Tensor, generator: torch.Generator) -> tuple[Tensor, Tensor]:
        """Sample `raw` `[B, D]`; return it with its relative log-density `[B]`."""
        h, raw = self._read(z), z.new_zeros(len(z), self.dim)
        for j, logits in enumerate(self._each_choice(h, raw)):
            noise = -torch.empty_like(logits).exponential_(generator=generator).log()  # Gumbel's
            index = (logits + noise).argmax(-1).float()
            self._put(raw, index, self.choices[j])
        if self.reals:
            self._draw_reals(self._all_seen(h, raw)[:, -1], raw, generator)
        return raw, self(z, raw)[0]

    def forward(self, z: Tensor, raw: Tensor) -> tuple[Tensor, Tensor]:
        """Return the relative log-density `[B]` of `raw` `[B, D]`, and the expected normalized score `[B]`."""
        h = self._read(z)
        seen = self._all_seen(h, raw)  # [B, C + 1, H]
        density = z.new_zeros(len(z))
        for group in self._groups():
            at, log_weights, weights, _ = group
            logits = log_weights + torch.einsum("bch,ckh->bck", seen[:, at], weights)
            index = _within(raw[:, self.choice_at[at]], group)[..., None]  # [B, n, 1]
            chosen = logits.log_softmax(-1).gather(2, index)[..., 0]
            prior = log_weights[torch.arange(len(at)), index[..., 0]]
            density = density + self._where_drawn(chosen - prior, raw, self.choice_of[at]).sum(1)
        if self.reals:
            within = self._log_bumps(raw[:, self.real_at], *self._bumps(seen[:, -1]))  # [B, R]
            density = density + self._where_drawn(within, raw, self.real_of).sum(1)
        return density, self.value(torch.tanh(h))[:, 0]

    def theta(self, raw: np.ndarray) -> np.ndarray:
        """Return θ float64 `[n, D]` of samples; a choice gives the center of its cell."""
        theta = raw.astype(np.float64)
        for column, program, cells in self.choices:
            mine = self._of(torch.as_tensor(raw), program).numpy()
            assert cells is not None
            theta[mine, column] = cells.middle(raw[mine, column].astype(np.int64))
        return theta

    # ------------------------------------------------------------ choices

    def _read(self, z: Tensor) -> Tensor:
        return self.second(torch.tanh(self.first(z)))  # [B, H], before its tanh

    def _groups(self) -> list[Group]:
        """Return the groups of choices; choices with many values are a separate group."""
        groups = [Group(self.narrow, self.log_weights, self.logits, self.seen)] if len(self.narrow) else []
        if len(self.wide):
            groups.append(Group(self.wide, self.wide_log_weights, self.wide_logits, self.wide_seen))
        return groups

    def _each_choice(self, h: Tensor, raw: Tensor) -> Iterator[Tensor]:
        """Yield the logits `[B, most values]` of each choice; after each, the caller writes the choice into `raw`."""
        groups = self._groups()
        for j, (column, program, _) in enumerate(self.choices):
            g, i = self.place[j]
            yield groups[g].log_weights[i] + torch.tanh(h) @ groups[g].logits[i].T
            added = groups[g].seen[i][_within(raw[:, column], groups[g])]
            h = h + (added * self._of(raw, program)[:, None] if self.mixed else added)

    def _all_seen(self, h: Tensor, raw: Tensor) -> Tensor:
        """Return the inputs of each choice, and last the input of all real numbers: `[B, C + 1, H]`."""
        if not self.choices:
            return torch.tanh(h)[:, None]
        drawn = raw[:, self.choice_at]
        groups = self._groups()
        parts = [group.seen[torch.arange(len(group.at)), _within(drawn[:, group.at], group)] for group in groups]
        added = parts[0] if len(parts) == 1 else torch.cat(parts, 1)[:, self.in_order]  # [B, C, H]
        added = self._where_drawn(added, raw, self.choice_of)
        return torch.tanh(torch.cat([h[:, None], h[:, None] + added.cumsum(1)], 1))

    # ------------------------------------------------------------ real numbers

    def _draw_reals(self, seen: Tensor, raw: Tensor, generator: torch.Generator) -> None:
        """Sample the real numbers into `raw`, each from one of its bumps by inverse transform sampling."""
        shares, means, scales = self._bumps(seen)  # [B, R, K]
        bump = torch.multinomial(shares.flatten(0, 1), 1, generator=generator).view(*means.shape[:2], 1)
        mean, scale = means.gather(2, bump)[..., 0], scales.gather(2, bump)[..., 0]  # [B, R]
        low, high = torch.sigmoid((-1 - mean) / scale), torch.sigmoid((1 - mean) / scale)
        quantile = low + (high - low) * torch.empty_like(mean).uniform_(generator=generator)
        drawn = (mean + scale * torch.logit(quantile, 1e-6)).clamp(-1.0, 1.0)
        if self.mixed:
            for r, part in enumerate(self.reals):
                self._put(raw, drawn[:, r], part)
        else:
            raw[:, self.real_at] = drawn

    def _bumps(self, seen: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Return shares, means and scales of all bumps: `[B, R, K]` each."""
        assert self.bumps is not None
        share, mean, scale = self.bumps(seen).view(len(seen), 3, len(self.reals), COMPONENTS).unbind(1)
        log_scale = (math.log(FIRST_SCALE) + scale).clamp(*LOG_SCALE_RANGE)
        shares, means = (self.first_shares + share).softmax(-1), MOST_MEAN * torch.tanh(self.first_means + mean)
        return shares, means, log_scale.exp()

    @staticmethod
    def _log_bumps(x: Tensor, shares: Tensor, means: Tensor, scales: Tensor) -> Tensor:
        """Return the log-density of x `[B, R]` relative to the uniform on [-1, 1]."""
        ends = torch.stack([x, torch.ones_like(x), -torch.ones_like(x)])[..., None]
        at, high, low = torch.sigmoid((ends - means) / scales)  # logistic cumulative distributions [B, R, K]
        density = at * (1 - at) / (scales * (high - low))
        return (2 * (shares * density).sum(-1) + SMALL).log()

    # ------------------------------------------------------------ programs of a mixture

    def _of(self, raw: Tensor, program: int) -> Tensor:
        """Return which rows belong to a program: bool `[B]`."""
        return torch.ones(len(raw), dtype=torch.bool) if program < 0 else raw[:, 0] == program

    def _where_drawn(self, values: Tensor, raw: Tensor, programs: Tensor) -> Tensor:
        """Set values `[B, n, ...]` to 0 in columns that the row's program does not have; `programs` `[n]`."""
        if not self.mixed:
            return values
        drawn = (programs < 0) | (programs == raw[:, :1])  # [B, n]
        return values * drawn.view(*drawn.shape, *(1,) * (values.dim() - 2))

    def _put(self, raw: Tensor, drawn: Tensor, part: Drawn) -> None:
        raw[:, part.column] = torch.where(self._of(raw, part.program), drawn, raw[:, part.column])


def _places(parts: Sequence[Drawn]) -> tuple[Tensor, Tensor]:
    """Return the indices in θ and the programs of sampled columns: int64 `[n]` each."""
    return tuple(torch.tensor([part[k] for part in parts], dtype=torch.long) for k in (0, 1))  # type: ignore[return-value]


def _by_width(choices: Sequence[Drawn]) -> tuple[Tensor, Tensor]:
    """Return the choices with few and with many values, int64: the two groups are padded separately."""
    wide = torch.tensor([part.cells is not None and part.cells.count > WIDE for part in choices], dtype=torch.bool)
    if wide.all():
        wide = ~wide
    return (~wide).nonzero()[:, 0], wide.nonzero()[:, 0]


def _log_weights(choices: Sequence[Drawn]) -> Tensor:
    """Return the log weights of the program `[C, most values]`, padded with IMPOSSIBLE."""
    cells = [part.cells for part in choices if part.cells is not None]
    weights = torch.full((len(cells), max((each.count for each in cells), default=0)), IMPOSSIBLE)
    for row, each in zip(weights, cells, strict=True):
        row[: each.count] = torch.as_tensor(np.log(each.shares))
    return weights
