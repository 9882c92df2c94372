"""Tests that every number on a page has a source: a generated table, or a mark that names a command or a file.

Numbers are percentages, decimals, signed numbers, intervals and percentage points. An interval is one number: a table
has it with both ends. A generated table of the page, or of
a page that it links to, is a source. So is a mark `<!-- source: COMMAND OR FILE -->` in the paragraph, item or table.
For a complete page, `<!-- source of this page: COMMAND OR FILE -->` stands above the first section. Read next:
`test_prose`.
"""

import re
from importlib.util import find_spec

import pytest

from tests.pages import LINK, ROOT, prose
from tests.test_prose import GENERATED, PAGES, read, said

NUMBER = r"\d+(?:,\d{3})*(?:\.\d+)?"
MEASURED = re.compile(
    rf"(?<![\w.,/^])(?:[-+]?{NUMBER}%|[-+]\d[\d.]*(?![\w-])|{NUMBER}(?= (?:percentage )?points)|\d+\.\d+(?![\w.]))"
    rf"|\[[-+]?{NUMBER}, [-+]?{NUMBER}\]"
)
DEFINED = re.compile(  # not measured: code, ranges, confidence levels, 0% and 100%, arXiv IDs
    r"`[^`]+`|(?:in|to|of) \[-?\d+, \d+\]|\b95%(?= (?:CI|bootstrap|confidence|interval))|\b(?:0|100)%|\d{4}\.\d{5}"
)
# A name and its number: versions, figures, licenses
VERSION = re.compile(r"\b(?:[A-Z][\w-]*|[a-z]+(?:-[a-z]+)+)\]?(?: below)?[ -]\d[\d.]*(?:,?(?: and| or| to)? \d[\d.]*)*")
MARK = re.compile(r"<!-- source: (.+?) -->")
INTERVAL = re.compile(rf"\[[-+]?({NUMBER})%?, [-+]?({NUMBER})%?\]")
PAGE_MARK = re.compile(r"<!-- source of this page: (.+?) -->")


def numbers(text):
    """Return the numbers of a text without signs. An interval is one, its lesser end first: -9 [-12, -6] is 9 less."""
    pairs = [sorted(pair, key=lambda end: float(end.replace(",", ""))) for pair in INTERVAL.findall(text)]
    return [f"[{low}, {high}]" for low, high in pairs] + re.findall(NUMBER, INTERVAL.sub("", text))


def known(path):
    """Return the numbers in generated tables of a page and of the pages that it links to."""
    linked = [path]
    for _, link in LINK.findall(prose(path.read_text())):
        file = link.partition("#")[0]
        linked += [(path.parent / file).resolve()] if file.endswith(".md") else []
    tables = (table[1] for page in linked if page.is_file() for table in GENERATED.finditer(page.read_text()))
    return set(numbers("\n".join(tables)))


def without_source(text, known):
    """Return a line for each paragraph with numbers without a source: the numbers and the first words."""
    if PAGE_MARK.search(text.partition("\n## ")[0]):
        return []
    lines = []
    for paragraph in re.split(r"\n\s*\n|\n(?=- )", prose(GENERATED.sub("", text))):
        if not MARK.search(paragraph):
            plain = VERSION.sub("", said(DEFINED.sub("", paragraph)))
            measured = [number for each in MEASURED.findall(plain) for number in numbers(each)]
            missing = [number for number in measured if number not in known]
            lines += [f"{', '.join(missing)}: {paragraph[:80]}"] if missing else []
    return lines


@pytest.mark.parametrize("name", PAGES)
def test_numbers_have_a_source(name):
    path = PAGES[name]
    assert without_source(path.read_text(), known(path)) == []


@pytest.mark.parametrize("name", PAGES)
def test_sources_exist(name):
    """A mark has its own line: Markdown after it on the same line would not be rendered."""
    text = read(name)
    marks = [*MARK.findall(text), *PAGE_MARK.findall(text)]
    assert (
        len(marks) == len(re.findall(r"^ *<!-- source.* -->$", text, re.M)) == len(re.findall(r"<!--\s*source", text))
    )
    for source in marks:
        module = re.match(r"python -m ([\w.]+)", source)
        if module:
            assert find_spec(module[1]), source
        elif not re.match(r"(?:regista|make) \w", source):
            assert (ROOT / source).is_file(), source


def test_a_number_without_a_source_is_found():
    page = "# A\n\nDR solves 84%.\n\n- PAIRED gains +5 points [-1, +12].\n\nPython 3.11 or 3.12, θ in [-1, 1].\n"
    assert [line.partition(":")[0] for line in without_source(page, set())] == ["84", "5, [1, 12]"]
    assert without_source(page, {"84", "5", "1", "12"}) == ["[1, 12]: - PAIRED gains +5 points [-1, +12]."]
    assert without_source(page, {"84", "5", "[1, 12]"}) == []
    assert without_source(page.replace("DR", "<!-- source: a.py -->\nDR"), {"5", "[1, 12]"}) == []
    assert without_source(f"<!-- source of this page: make demo -->\n{page}", set()) == []
    assert without_source(f"{page}\n## B\n\n<!-- source of this page: make demo -->\n", set()) != []
    table = "<!-- study: fast, teams -->\n| 84% |\n<!-- end -->\n"
    assert without_source(table, set()) == [] and len(GENERATED.findall(table)) == 1
