"""The plan of a manual curriculum, as text: lessons, each with a region of levels and a criterion to move on.

    "gravity=5..7, ground=grass|ice until success 0.8"
    "gravity=5..15 until return 0.5 or steps 20%"
    "all"

A region restricts parameters, in their own units, to a range, a value, or options. Other parameters keep their full
range; `all` restricts none. An option with a sign of this syntax in its name is quoted: `sky='wet, cold'`. Read next:
`levels.regions`, from names to columns of θ; `methods.lessons`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import NamedTuple

from ued.settings import Checked, setting

FORM = '"NAME=VALUES, ... until CRITERION", as in "gravity=5..7, ground=grass|ice until success 0.8"'
QUOTES = "quote an option with a comma, as in sky='wet, cold'"
MEANS, COUNTS = ("success", "return"), ("episodes", "steps")
NUMBER = r"[-+]?[\d_]*\.?\d+(?:e[-+]?\d+)?"
CRITERION = re.compile(rf"({'|'.join((*MEANS, *COUNTS))})\s+({NUMBER})(\s*%)?", re.IGNORECASE)
QUOTED = r"(?<![^=|\s])(?:'[^']*'|\"[^\"]*\")(?=[\s,|]|$)"  # an option in quotes; other quotes belong to a name
MIDDLE = "all=theta -0.25..0.25 until success 0.8"  # the first lesson unless a plan is given


class Criterion(NamedTuple):
    """A criterion for the start of the next lesson: the `measure` is at least `least`.

    `measure` is a mean over the last episodes, "success" (a rate from 0 to 1) or "return". Or it is the length of the
    lesson in "episodes", in "steps", or as a "share" of the steps of the run.
    """

    measure: str
    least: float


class Lesson(NamedTuple):
    """A lesson: its text, names of parameters with the text of their values, and alternative criteria."""

    text: str
    region: tuple[tuple[str, str], ...]
    until: tuple[Criterion, ...]


def lesson_of(text: str) -> Lesson:
    """Parse a lesson. Raises ValueError for an invalid text."""
    region, *ends = split(r"\s+until\s+", text.strip())
    if len(ends) > 1:
        raise ValueError(f"the lesson {text!r} has more than one 'until'; join its criteria by 'or'")
    until = tuple(_criterion(text, part) for part in re.split(r"\s+or\s+", ends[0])) if ends else ()
    entries = () if region == "all" else tuple(_entry(text, part) for part in split(",", region))
    names = [name for name, _ in entries]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise ValueError(
            f"the lesson {text!r} has {twice!r} twice; give each parameter one range, or options joined as in a|b"
        )
    return Lesson(text, entries, until)


def split(separator: str, text: str) -> list[str]:
    """Split a text at a separator, a regular expression, except within quoted options."""
    found = [match.span(1) for match in re.finditer(f"{QUOTED}|({separator})", text) if match[1] is not None]
    ends = [0, *(end for span in found for end in span), len(text)]
    return [text[start:end] for start, end in zip(ends[::2], ends[1::2], strict=True)]


def _entry(text: str, part: str) -> tuple[str, str]:
    name, equals, values = (word.strip() for word in part.partition("="))
    if not (name and equals and values):
        raise ValueError(f"the lesson {text!r} has the region {part.strip()!r}; a lesson is 'all', or {FORM}; {QUOTES}")
    return name, values


def _criterion(text: str, part: str) -> Criterion:
    found = CRITERION.fullmatch(part.strip())
    if not found:
        raise ValueError(
            f"the lesson {text!r} has the criterion {part.strip()!r}; criteria are success 0.8, return 0.5, episodes "
            "500, steps 200_000, and steps 20% of the run, joined by 'or'"
        )
    measure, least = found[1].lower(), float(found[2].replace("_", "")) / (100 if found[3] else 1)
    if found[3] and measure not in ("success", "steps"):
        raise ValueError(f"the lesson {text!r} has {measure} in percent; only success and steps may be in percent")
    measure = "share" if found[3] and measure == "steps" else measure
    if (measure in ("success", "share") and not 0 < least <= 1) or (measure in COUNTS and least < 1):
        most = "above 0 and at most 1 (100%)" if measure in ("success", "share") else "at least 1"
        raise ValueError(f"the lesson {text!r} has the criterion {part.strip()!r}, which must be {most}")
    return Criterion(measure, least)


@dataclass(frozen=True)
class LessonsConfig(Checked):
    """Settings of a manual curriculum."""

    plan: tuple[str, ...] = setting(
        (MIDDLE, "all"),
        'ordered lessons, each "NAME=VALUES, ... until CRITERION": ranges 5..7, values 5, options a|b, or '
        '"all"; criteria success 0.8, return 0.5, episodes 500 or steps 200_000',
        metavar="LESSON",
    )
    increments: int = setting(
        1,
        "increments by which ranges move from a lesson to the next, one each time the criterion holds; 1: at once; 100 "
        'with "steps": a linear schedule',
        ">=1",
        most=1_000_000,
    )
    window: int = setting(
        100, "episodes to average success and return over; minimum episodes per increment", ">=1", most=1_000_000
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        self.lessons()

    def lessons(self) -> tuple[Lesson, ...]:
        """Return the lessons of the plan.

        Raises:
            ValueError: a plan without lessons, or with a lesson that never ends.
        """
        plan = tuple(map(lesson_of, self.plan))
        if not plan:
            raise ValueError(f"plan must have at least one lesson, {FORM}")
        for lesson in plan[:-1]:
            if not lesson.until:
                raise ValueError(f"the lesson {lesson.text!r} never ends; all but the last need 'until CRITERION'")
        if plan[-1].until:
            raise ValueError(f"the last lesson, {plan[-1].text!r}, lasts until the end of the run; remove its 'until'")
        return plan
