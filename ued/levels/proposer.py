"""The adversary of a space of levels: it chooses θ or codes in one step, or builds levels step by step.

| levels | `builder = direct` | `builder = steps` |
|---|---|---|
| vectors of parameters, programs, mixtures | `Adversary`, the default | – |
| a family with `parameters` | `CodeAdversary` | – |
| a family with a `builder` | – | `Builder`, the default |

Read next: `core.families`, the optional attributes of a family; `levels.teacher`, which proposes these levels.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
import torch

from ued.config import AdversaryConfig
from ued.core.cells import bin_center
from ued.core.families import LevelFamily
from ued.core.level_space import LevelSpace
from ued.core.parameters import cells_in, family_columns
from ued.levels.adversary import Adversary, Proposals
from ued.levels.builder import Builder, builder_setting


class Proposer(Protocol):
    """The interface of an adversary for the teacher; see `Adversary` and `Builder`.

    Attributes:
        record_fields: the fields of a level record that hold one of its proposals.
    """

    @property
    def record_fields(self) -> list[tuple[Any, ...]]: ...

    def read(self, records: np.ndarray) -> Any:
        """Return the proposals in these fields of level records `[n]`."""

    def propose(self, count: int, context: np.ndarray | None = None) -> Any:
        """Return `count` proposals, a NamedTuple with the names of `record_fields`."""

    def theta(self, proposals: Any) -> np.ndarray:
        """Return the proposed θ or codes `[n, D]`."""

    def learn(self, proposals: Any, score: np.ndarray) -> dict[str, float]:
        """Update on the scores `[n]` of proposals."""

    def state_dict(self) -> dict[str, Any]: ...

    def load_state_dict(self, state: dict[str, Any]) -> None: ...


class CodeAdversary(Adversary):
    """Chooses all columns of a family's codes in one step.

    Args:
        space: the space of levels, whose family declares `parameters`.
        config, generator, context_size: see `Adversary`.
    """

    def __init__(
        self, space: LevelSpace, config: AdversaryConfig, generator: torch.Generator, context_size: int | None = None
    ) -> None:
        family = space.level_family
        columns = None if family is None else family_columns(family)
        assert family is not None and columns is not None
        super().__init__(columns, config, generator, context_size)
        self.space, self.family = space, family
        self.cells = [(column, cells) for column, draw in enumerate(columns) if (cells := cells_in(draw)) is not None]

    def theta(self, proposals: Proposals) -> np.ndarray:
        """Return the proposed codes, float64 `[n, D]` in [-1, 1].

        Valid codes are decoded and encoded again, so that equal levels have equal codes.
        """
        codes = super().theta(proposals)
        for column, cells in self.cells:
            codes[:, column] = bin_center(cells.index(codes[:, column]), cells.count)
        for row in np.flatnonzero(self.space.valid(codes)):
            codes[row] = self.family.encode(self.family.decode(codes[row]))
        return codes


def make_adversary(
    space: LevelSpace, config: AdversaryConfig, generator: torch.Generator, context_size: int | None = None
) -> Proposer:
    """Return the adversary that `config.builder` names, for these levels.

    Raises `ValueError` if this adversary cannot choose such levels.
    """
    family, kind = space.level_family, config.builder
    if family is None:
        if kind == "steps":
            raise ValueError(
                "the builder 'steps' needs levels of a LevelFamily with a `builder`; these are vectors of parameters, "
                f"so use {builder_setting('direct')}"
            )
        return Adversary(space.parameters, config, generator, context_size, space.program_parameters)
    builder = getattr(family, "builder", None)
    if kind == "steps" or (kind == "auto" and builder is not None):
        if builder is None:
            raise ValueError(_lacking(family, "steps", "builder"))
        if context_size is not None:
            raise ValueError(
                "an adversary that builds levels starts from a random vector; use context='random' "
                "(--METHOD.adversary.context random)"
            )
        return Builder(builder, config, generator)
    if family_columns(family) is None:
        raise ValueError(_lacking(family, kind, "parameters"))
    return CodeAdversary(space, config, generator, context_size)


def _lacking(family: LevelFamily, kind: str, lacks: str) -> str:
    """Return the error message for a family whose levels cannot be chosen; it names the missing attribute."""
    name = type(family).__name__
    other = {"builder": "parameters", "parameters": "builder"}[lacks]
    if getattr(family, other, None) is not None:
        right = {"builder": "direct", "parameters": "steps"}[lacks]
        return f"the builder {kind!r} needs a `{lacks}` of {name}, which has none; use {builder_setting(right)}"
    return (
        f"levels of {name} can be sampled and mutated, but not chosen by theta; use dr, plr, robust_plr, accel, "
        f"cenie, sfl or ncc, or give {name} `parameters`, the columns of its codes, or a `builder`, the steps in which "
        "its levels are built (see ued.LevelFamily)"
    )
