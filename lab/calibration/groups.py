"""Groups of simulator numbers that belong to one fitted table, and the family of GRF measurements that identifies them.

    python -m lab.calibration.groups            lists all groups and their numbers

Read next: `profile.py`, which takes these names.
"""

from __future__ import annotations

import ast
from contextlib import suppress
from pathlib import Path

from lab.calibration.knobs import evaluated, in_source, law_class
from lab.football_mutants import FOOTBALL

LAGS = ("LAG_FROM_REST", "LAG_SLOW", "LAG_WALKING", "LAG_RUNNING", "LAG_SPRINTING")
DRIBBLE = ("GAITS", "TOUCH", "AT_FOOT", "TURN_BACK", "ARC", "BRAKES")
# group: the family, and laws with all of their numbers, or single numbers
GROUPS: dict[str, tuple[str, tuple[str, ...]]] = {
    "running": ("motion:start_rows,curve_rows", ("physics.running.BRAKING", "physics.running.START")),
    "lags": ("motion:start_rows,curve_rows", tuple(f"physics.running.{name}" for name in LAGS)),
    "bend": ("chases", ("physics.running.BEND",)),
    "slide": ("motion:slide_rows,tired_rows", ("physics.motion.SLIDE", "physics.motion.TIRING")),
    "dribble": ("motion:steady_rows,curve_rows,carry_rows", tuple(f"physics.dribble.{name}" for name in DRIBBLE)),
    "turns": ("motion:drawn_turn_rows", ("control.actions.TURNS",)),
    "pass_swing": ("passes", ("skills.kicks.SWING", "skills.kicks.BEHIND")),
    "shot_swing": ("shots", ("skills.kicks.SWING", "skills.kicks.BEHIND")),
    "flight": ("passes", ("skills.passes.FLIGHT",)),
    "shots": ("shots", ("skills.shots.POWER", "skills.shots.BAD")),
    "saves": ("keeper", ("skills.saves.SAVE",)),
    "hands": ("keeper", ("skills.hands.HOLD",)),
    "contacts": ("keeper", ("skills.contacts.CLAIM", "skills.contacts.CATCH")),
    "keeper": ("keeper", ("ai.keeper.OUT", "ai.keeper.SLIDE_OUT")),
    "tackles": ("tackles", ("skills.tackles.TACKLE", "skills.tackles.SLIDING")),
    "blocks": ("blocks", ("skills.blocks.BLOCK",)),
    "attack": ("matches", tuple(f"ai.attack.FORCES.{name}" for name in ("rivals_push", "rivals_most", "lines_push"))),
    "worth": ("matches", ("ai.passing.WORTH",)),
}


def group(name: str) -> list[str]:
    """Return the names of a group's numbers. Raises ValueError for an unknown group."""
    if name not in GROUPS:
        raise ValueError(f"a group is one of {', '.join(GROUPS)}, not {name!r}")
    return [number for law in GROUPS[name][1] for number in numbers(law)]


def numbers(law: str) -> list[str]:
    """Return the names of all nonzero numbers of a law, of a bare tuple, or of a single field."""
    words = law.split(".")
    field = words.pop() if words[-1].islower() else ""
    module, name = ".".join(words[:-1]), words[-1]
    tree = ast.parse((FOOTBALL / Path(*module.split(".")).with_suffix(".py")).read_text())
    made = law_class(tree, name)
    if not made or field:
        return spelled(law, in_source(module, name, field))
    found = []
    for node in ast.walk(tree):
        for line in node.body if isinstance(node, ast.ClassDef) and node.name == made else ():
            if isinstance(line, ast.AnnAssign) and line.value is not None:
                with suppress(ValueError):  # skips numbers that are computed from others
                    found += spelled(f"{law}.{getattr(line.target, 'id', '')}", evaluated(line.value))
    return found


def spelled(name: str, value: float | tuple[float, ...]) -> list[str]:
    """Return the names of the nonzero numbers of a value; no factor changes a zero."""
    if isinstance(value, tuple):
        return [f"{name}[{k}]" for k, each in enumerate(value) if each != 0.0]
    return [name] if value != 0.0 else []


if __name__ == "__main__":
    for each, (family, _) in GROUPS.items():
        print(f"{each} ({family}): {' '.join(group(each))}")
