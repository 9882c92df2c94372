"""What a program's own rules do to uniform draws: the report of an impossible or wasteful program.

Read next: `scene.program`.
"""

from __future__ import annotations

from dataclasses import dataclass

from scenic_lite.scene.constraints import Constraint

SHOWN = 8  # rules, the worst first


@dataclass(frozen=True)
class RejectionReport:
    """How many of some uniform draws of θ were valid, and what share each rule rejected by itself.

    A draw may break several rules, so the shares need not add up.
    """

    file: str
    draws: int
    accepted: int
    rejected: tuple[tuple[Constraint, float], ...]  # only rules that rejected something, the worst first

    @property
    def acceptance(self) -> float:
        """Share of the draws that were valid."""
        return self.accepted / self.draws

    def __str__(self) -> str:
        if self.accepted:
            head = f"{self.file}: {100 * self.acceptance:.1f} % of {self.draws} draws are valid"
        else:
            head = f"{self.file}: no valid scene in {self.draws} draws"
        return "\n".join([head, *self.rules()])

    def rules(self) -> list[str]:
        """One line for each rule that rejected something."""
        rows = [(f"    line {rule.place.line}: {rule.label}", share) for rule, share in self.rejected[:SHOWN]]
        width = max((len(text) for text, _ in rows), default=0) + 6
        lines = [f"{text:<{width}}rejected {100 * share:.1f} %" for text, share in rows]
        if len(self.rejected) > SHOWN:
            lines.append(f"    and {len(self.rejected) - SHOWN} rules more")
        if any(rule.probability < 1 for rule, _ in self.rejected):
            lines.append("    (a soft requirement rejects in its share of the scenes only, and makes no draw invalid)")
        return lines
