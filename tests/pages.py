"""Reads pages of the documentation, and writes the files that their blocks contain.

A fenced block below a line "`a/file.py`:" is the content of that file. Other `python` blocks run in one namespace, and
`sh` blocks run line by line. `console` blocks do not run; tests check only their flags. Read next: `test_docs`.
"""

import ast
import re
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parent.parent
STEP = re.compile(r"(?:^(`[^`\n]+`|In `[^\n]+):\n\n)?^```(\w*)\n(.*?)^```", re.M | re.S)
LINK = re.compile(r"(!?)\[(?:[^\[\]]|\[[^\]]*\])*\]\((?!\w+:)([^)\s]+)\)")


class Block(NamedTuple):
    """A fenced block: the line above it that names its file or an edit of a file, its language, and its text."""

    where: str
    language: str
    text: str

    @property
    def names(self) -> list[str]:
        return re.findall(r"`([^`]+)`", self.where)


def blocks(text: str) -> list[Block]:
    """Return the fenced blocks of a page in order."""
    return [Block(*found) for found in STEP.findall(text)]


def commands(block: Block) -> list[str]:
    """Return the commands of a block, without comments and with continued lines joined."""
    lines = block.text.replace("\\\n", " ").splitlines()
    return [line for line in (re.sub(r"(^|\s)#.*", "", line).strip() for line in lines) if line]


def prose(text: str) -> str:
    """Return a page without its fenced blocks."""
    return re.sub(r"^```.*?^```$", "", text, flags=re.M | re.S)


def headings(text: str) -> set[str]:
    """Return the anchors of a page's headings, as GitHub generates them."""
    found = re.findall(r"^#+ (.+)$", prose(text), re.M)
    return {re.sub(r"[^\w\- ]", "", re.sub(r"\]\([^)]*\)", "", title).lower()).replace(" ", "-") for title in found}


def dead_links(path: Path) -> list[str]:
    """Return the links of a page whose file, or whose heading in that file, does not exist."""
    dead = []
    for _, link in LINK.findall(prose(path.read_text())):
        file, _, heading = link.partition("#")
        target = (path.parent / file).resolve() if file else path
        if not target.is_file() or (heading and heading not in headings(target.read_text())):
            dead.append(link)
    return dead


def pictures(path: Path) -> list[Path]:
    """Return the pictures that a page shows."""
    found = LINK.findall(prose(path.read_text()))
    return [(path.parent / link).resolve() for shown, link in found if shown]


def write(path: Path, text: str) -> None:
    """Write a file from a page; the file must not exist yet."""
    assert not path.exists(), f"{path} exists already"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)


def add_row(path: Path, table: str, row: str) -> None:
    """Insert a row below the last row of a table: the first tuple in the value assigned to the name `table`."""
    text = path.read_text()
    for node in ast.parse(text).body:
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        if any(isinstance(target, ast.Name) and target.id == table for target in targets):
            rows = next(part for part in ast.walk(node.value) if isinstance(part, ast.Tuple))
            lines = text.splitlines(keepends=True)
            lines.insert(rows.elts[-1].end_lineno, row)
            path.write_text("".join(lines))
            return
    raise AssertionError(f"{path} has no {table}")
