"""A Griffe extension: the pages of Python show what a function returns as a section, with its type.

A docstring says it once, in its summary: "Return the seed of an episode's luck". Such a summary becomes the section
`Returns` of the page, unless the docstring has one. Read next: `mkdocs.yml`.
"""

from __future__ import annotations

import re
from typing import Any

import griffe

STATED = re.compile(r"(.*?)(?:^|[;,] |\. | and )[Rr]eturns? (.+)", re.S)
SECTION = re.compile(r"^Returns:\s*$", re.M)


def with_returns(text: str) -> str:
    """Return a docstring with a section `Returns` for what its summary says is returned.

    A summary that begins with "Return" moves there whole, of "Play; return the score" the second half is repeated. The
    docstring stays as it is if it has such a section, or if its summary says nothing of that.
    """
    summary, _, rest = text.partition("\n\n")
    stated = STATED.match(summary)
    if not stated or SECTION.search(text):
        return text
    said = " ".join(stated[2].split())
    section = f"Returns:\n    : {said}"  # what stands before the first colon would be its name
    about, raises, errors = f"\n\n{rest}".partition("\n\nRaises:")
    parts = (summary if stated[1] else "", about.strip(), section, f"{raises.strip()}{errors}")
    return "\n\n".join(part for part in parts if part)


class ReturnsOfSummaries(griffe.Extension):
    """Adds the section to every function that returns something."""

    def on_function_instance(self, *, func: griffe.Function, **_: Any) -> None:
        """Extend the docstring of a function."""
        if func.docstring and func.returns is not None and str(func.returns) != "None":
            func.docstring.value = with_returns(func.docstring.value)
