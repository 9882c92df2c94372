"""What the language is told of a world: the modules that programs may import.

Read next: `envs.football.scenic.domain`, the one Domain there is.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from scenic_lite.core.world import World


@dataclass(frozen=True)
class Domain:
    """A world that programs can be about.

    `library` maps a dotted module name, aliases included, to the `.scenic` file that it means. `default_model` is
    imported by a program file that has no `model` line of its own and imports none of the library. `params` are those
    parameters of a program that mean something to this world: one that is almost spelt like them is warned of. `world`
    is how its simulator shows itself to behaviors; None if it has none.
    """

    name: str
    library: Mapping[str, Path] = field(default_factory=dict)
    default_model: str | None = None
    params: frozenset[str] = frozenset()
    world: World | None = None
