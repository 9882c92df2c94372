"""What a program's own constraints do to uniform draws: the report of an impossible or wasteful program.

Read next: `scene.program`.
"""

from __future__ import annotations

from dataclasses import dataclass

from scenic_lite.scene.constraints import Constraint

SHOWN = 8  # constraints, the worst first


@dataclass(frozen=True)
class RejectionReport:
    """How many of some uniform draws of θ were valid, and what share each constraint rejected by itself.

    A draw may violate several, so the shares need not add up.
    """

    file: str
    draws: int
    accepted: int
    rejected: tuple[tuple[Constraint, float], ...]  # only those that rejected something, the worst first

    @property
    def acceptance(self) -> float:
        """Return the share of the draws that were valid."""
        return self.accepted / self.draws

    def __str__(self) -> str:
        if self.accepted:
            head = f"{self.file}: {100 * self.acceptance:.1f} % of {self.draws} draws are valid"
        else:
            head = f"{self.file}: no valid scene in {self.draws} draws"
        return "\n".join([head, *self.lines()])

    def lines(self) -> list[str]:
        """Return one line for each constraint that rejected something."""
        rows = [
            (f"    line {constraint.place.line}: {constraint.label}", share)
            for constraint, share in self.rejected[:SHOWN]
        ]
        width = max((len(text) for text, _ in rows), default=0) + 6
        lines = [f"{text:<{width}}rejected {100 * share:.1f} %" for text, share in rows]
        if len(self.rejected) > SHOWN:
            lines.append(f"    and {len(self.rejected) - SHOWN} more")
        if any(constraint.probability < 1 for constraint, _ in self.rejected):
            lines.append("    (a soft requirement rejects in its share of the scenes only, and makes no draw invalid)")
        return lines
