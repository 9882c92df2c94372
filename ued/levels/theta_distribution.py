"""The adversary's distribution over θ: it begins as what the program draws, and can put its mass anywhere.

    h = tanh(W z + c)                                       z: a random vector, or what a student sees
    choice_j ~ softmax(log weights_j + A_j h_j)             one after another: h_j also sees the choices before j
    real_d   ~ sum over k of share_dk · bump(mean_dk, scale_dk)     all at once: they see z and every choice

A choice is a column that stands for one of a few values: `Uniform`, `Discrete`, an integer, the program of a mixture.
Its categorical begins at the program's own weights, so no option is hard to reach because of its place in a list. A
real number has COMPONENTS bumps, logistic distributions cut off at -1 and 1, which together begin nearly uniform; the
shares can move mass to a distant bump at once, and several bumps can stay. A_j, and all that makes shares, means and
scales differ from where they begin, are 0 at first.

Densities are relative to the program's: log pi(θ) / pi_0(θ), where pi_0 is what domain randomization draws, uniform in
θ. So they are 0 at the beginning, and the mean of their negatives is -KL(pi, pi_0) ≤ 0, whatever the columns are.
Read next: `levels.adversary`, which learns it; `levels.unimodal`, the thesis's Gaussian in its place.
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

# The bumps of each real number as they begin: together uniform within a few percent, and symmetric.
FIRST_MEANS = (-0.98, -0.49, 0.0, 0.49, 0.98)
FIRST_SHARES = (0.7, 1.0, 1.0, 1.0, 0.7)  # with any sum
FIRST_SCALE = 0.2
COMPONENTS = len(FIRST_MEANS)
MOST_MEAN = 1.05  # a mean stays within this on either side
LOG_SCALE_RANGE = (math.log(0.01), math.log(3.0))  # from 2 % of [-1, 1] to all of it
SMALL = 1e-9  # a density where there is no bump: its logarithm stays finite


class Drawn(NamedTuple):
    """A column as it is drawn: where in θ, only for which program of a mixture (-1: always), and its cells if any."""

    column: int
    program: int
    cells: Cells | None


def layout(draws: Sequence[Parameter], program_parameters: Sequence[Sequence[Parameter]] = ()) -> list[Drawn]:
    """Return what is to be drawn for the columns of θ; on a mixture column 0, then each program's own columns."""
    if not program_parameters:
        return [Drawn(column, -1, choice_in(draw)) for column, draw in enumerate(draws)]
    drawn = [Drawn(0, -1, choice_in(draws[0]))]
    for program, own in enumerate(program_parameters):
        drawn += [Drawn(column, program, choice_in(draw)) for column, draw in enumerate(own, 1)]
    return drawn


class ThetaDistribution(nn.Module):
    """z `[B, Z]` -> a distribution over θ for each row, and the score to expect.

    What is drawn, `raw` `[B, D]`, is θ itself where a column is a real number and the index of the value where it is a
    choice; 0 in columns that the chosen program of a mixture does not have.

    Args:
        draws, program_parameters: the columns of θ, see `layout`.
        context_size: Z.
        hidden: units of each of the two layers.
        generator: of the first weights.
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
        self.log_weights = _log_weights(self.choices)  # [C, most values]
        self.first, self.second = (linear(size, hidden, math.sqrt(2), generator) for size in (context_size, hidden))
        self.value = linear(hidden, 1, 0.0, generator)
        self.logits = nn.Parameter(torch.zeros(*self.log_weights.shape, hidden))  # A
        self.seen = nn.Parameter(torch.zeros(*self.log_weights.shape, hidden))  # what a choice adds to later h
        self.bumps = linear(hidden, 3 * len(self.reals) * COMPONENTS, 0.0, generator) if self.reals else None
        self.first_shares = torch.tensor(FIRST_SHARES).log()
        self.first_means = torch.atanh(torch.tensor(FIRST_MEANS) / MOST_MEAN)

    # ------------------------------------------------------------ both ways

    def sample(self, z: Tensor, generator: torch.Generator) -> tuple[Tensor, Tensor]:
        """Draw `raw` `[B, D]`; return it with its relative log-density `[B]`."""
        h, raw = self._read(z), z.new_zeros(len(z), self.dim)
        for j, logits in enumerate(self._each_choice(h, raw)):
            noise = -torch.empty_like(logits).exponential_(generator=generator).log()  # Gumbel's
            index = (logits + noise).argmax(-1).float()
            self._put(raw, index, self.choices[j])
        if self.reals:
            self._draw_reals(self._all_seen(h, raw)[:, -1], raw, generator)
        return raw, self(z, raw)[0]

    def forward(self, z: Tensor, raw: Tensor) -> tuple[Tensor, Tensor]:
        """Return the relative log-density `[B]` of `raw` `[B, D]`, and the score to expect `[B]`, normalized."""
        h = self._read(z)
        seen = self._all_seen(h, raw)  # [B, C + 1, H]
        density = z.new_zeros(len(z))
        if self.choices:
            logits = self.log_weights + torch.einsum("bch,ckh->bck", seen[:, :-1], self.logits)
            index = raw[:, self.choice_at].long()[..., None]  # [B, C, 1]
            chosen = logits.log_softmax(-1).gather(2, index)[..., 0]
            prior = self.log_weights[torch.arange(len(self.choices)), index[..., 0]]
            density = density + self._where_drawn(chosen - prior, raw, self.choice_of).sum(1)
        if self.reals:
            within = self._log_bumps(raw[:, self.real_at], *self._bumps(seen[:, -1]))  # [B, R]
            density = density + self._where_drawn(within, raw, self.real_of).sum(1)
        return density, self.value(torch.tanh(h))[:, 0]

    def theta(self, raw: np.ndarray) -> np.ndarray:
        """Return θ float64 `[n, D]` for what was drawn: of a choice the middle of its cell."""
        theta = raw.astype(np.float64)
        for column, program, cells in self.choices:
            mine = self._of(torch.as_tensor(raw), program).numpy()
            assert cells is not None
            theta[mine, column] = cells.middle(raw[mine, column].astype(np.int64))
        return theta

    # ------------------------------------------------------------ choices

    def _read(self, z: Tensor) -> Tensor:
        return self.second(torch.tanh(self.first(z)))  # [B, H], before its tanh

    def _each_choice(self, h: Tensor, raw: Tensor) -> Iterator[Tensor]:
        """Yield the logits `[B, most values]` of each choice, which the caller then puts into `raw`."""
        for j, (column, program, _) in enumerate(self.choices):
            yield self.log_weights[j] + torch.tanh(h) @ self.logits[j].T
            added = self.seen[j][raw[:, column].long()]
            h = h + (added * self._of(raw, program)[:, None] if self.mixed else added)

    def _all_seen(self, h: Tensor, raw: Tensor) -> Tensor:
        """Return what each choice sees, and last what all real numbers see: `[B, C + 1, H]`."""
        if not self.choices:
            return torch.tanh(h)[:, None]
        added = self.seen[torch.arange(len(self.choices)), raw[:, self.choice_at].long()]  # [B, C, H]
        added = self._where_drawn(added, raw, self.choice_of)
        return torch.tanh(torch.cat([h[:, None], h[:, None] + added.cumsum(1)], 1))

    # ------------------------------------------------------------ real numbers

    def _draw_reals(self, seen: Tensor, raw: Tensor, generator: torch.Generator) -> None:
        """Draw the real numbers into `raw`, each from one of its bumps by the inverse of its distribution."""
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
        """Return log of twice the density of x `[B, R]`: relative to the uniform on [-1, 1]."""
        ends = torch.stack([x, torch.ones_like(x), -torch.ones_like(x)])[..., None]
        at, high, low = torch.sigmoid((ends - means) / scales)  # logistic cumulative distributions [B, R, K]
        density = at * (1 - at) / (scales * (high - low))
        return (2 * (shares * density).sum(-1) + SMALL).log()

    # ------------------------------------------------------------ programs of a mixture

    def _of(self, raw: Tensor, program: int) -> Tensor:
        """Return which rows have what belongs to a program: bool `[B]`."""
        return torch.ones(len(raw), dtype=torch.bool) if program < 0 else raw[:, 0] == program

    def _where_drawn(self, values: Tensor, raw: Tensor, programs: Tensor) -> Tensor:
        """Return values `[B, n, ...]` with 0 for what the row's program does not have; `programs` `[n]`."""
        if not self.mixed:
            return values
        drawn = (programs < 0) | (programs == raw[:, :1])  # [B, n]
        return values * drawn.view(*drawn.shape, *(1,) * (values.dim() - 2))

    def _put(self, raw: Tensor, drawn: Tensor, part: Drawn) -> None:
        raw[:, part.column] = torch.where(self._of(raw, part.program), drawn, raw[:, part.column])


def _places(parts: Sequence[Drawn]) -> tuple[Tensor, Tensor]:
    """Return the columns of θ and the programs of what is drawn: int64 `[n]` each."""
    return tuple(torch.tensor([part[k] for part in parts], dtype=torch.long) for k in (0, 1))  # type: ignore[return-value]


def _log_weights(choices: Sequence[Drawn]) -> Tensor:
    """Return the logarithms of the program's weights `[C, most values]`, IMPOSSIBLE behind a choice's last value."""
    cells = [part.cells for part in choices if part.cells is not None]
    weights = torch.full((len(cells), max((each.count for each in cells), default=0)), IMPOSSIBLE)
    for row, each in zip(weights, cells, strict=True):
        row[: each.count] = torch.as_tensor(np.log(each.shares))
    return weights
