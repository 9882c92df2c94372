"""Tests of the prose: American spelling, words of the field, lengths of pages, a command with every generated table.

Only patterns with few false positives are forbidden. Code, names of files and quoted output are exempt. Read next:
`test_docs`, which runs the blocks of pages.
"""

import io
import re
import tokenize

import pytest

from tests.pages import ROOT, blocks, prose

MOST = {"README": 60, "RESULTS": 150, "TRANSFER": 120, "BENCHMARK": 120, "RELIABILITY": 30, "CHANGELOG": 100}  # lines
PAGES = {name: ROOT / f"{name}.md" for name in MOST} | {
    path.relative_to(ROOT).as_posix(): path for path in sorted((ROOT / "docs").rglob("*.md"))
}
READMES = (
    *("CONTRIBUTING.md", "SECURITY.md", "ued/README.md", "envs/football/README.md", "envs/football/DYNAMICS.md"),
    *("envs/grf/README.md", "lab/README.md", "lab/grf/data/README.md"),
)

BRITISH = (  # stems of words with a different American spelling
    "(?:behavi|col|fav|neighb|hon|lab)our",
    *("centre", "metre\\b", "metres\\b", "licence", "defence", "offence", "grey", "programme\\b", "catalogue"),
    *("learnt", "burnt", "spelt", "whilst", "artefact", "judgement", "practis", "analys(?:e|ed|ing)\\b"),
    *("labelled", "labelling", "modelled", "modelling", "travelled", "cancelled", "signalled"),
    "(?:random|organ|general|optim|maxim|minim|normal|initial|recogn|summar|real|penal|visual|parallel|custom|priorit|"
    "standard|regular|emphas|util|stabil|vector|discret|special|serial|final|local|factor|character|categor)is(?:e|ing|at|er)",
)
SPELLING = rf"\b\w*(?:{'|'.join(BRITISH)})\w*"
PACKAGES = ("ued", "kernels", "scenic_lite", "envs", "minigames", "experiments", "lab")
IDIOMS = (  # forbidden idioms, and words of the field that replace them
    (r"told", "specify, report"),
    (r"anew", "again"),
    (r"mended", "fixed"),
    (r"(?:uniform|same) keys", "random policy, same actions"),
    (r"(?:is|was|are|were|not|un) ?paid|paid for|pays? (?:for|where)", "rewarded"),
    (r"of whom|from whom", "a plain sentence"),
    (r"he|him|his", "it: a policy, an agent, a player"),
    (r"what is (?:hard|rare|easy|held out|learned)", "a noun: hard levels"),
    (r"nothing was searched", "no setting was tuned"),
    (r"nobody else|somebody (?:else|should)", "another user"),
)
ENGINES = r"\| ?(?:here|there) ?\||\((?:here|there) [\d`]|goals (?:here|there)\b|\bin the engine there\b"
HASH = r"\b(?=[0-9]*[a-f])(?=[a-f]*[0-9])[0-9a-f]{7,40}\b"

GENERATED = re.compile(r"^<!-- (?!end|source)[\w:, ]+ -->\n(.*?)^<!-- end -->", re.M | re.S)
COMMAND = re.compile(r"(?:python -m|regista|make) \w")


def read(name):
    """Return the text of a page."""
    return (PAGES.get(name) or ROOT / name).read_text()


def said(text):
    """Return the prose of a page: without blocks, code, targets of links and comments."""
    text = re.sub(r"<!--.*?-->", "", prose(text), flags=re.S)
    return re.sub(r"\]\([^)]*\)", "]", re.sub(r"`[^`\n]+`", "``", text))


def found(pattern, text):
    """Return all matches in a text, each with 30 characters of context on both sides."""
    return [text[max(0, match.start() - 30) : match.end() + 30] for match in re.finditer(pattern, text, re.I)]


@pytest.mark.parametrize("name", [*PAGES, *READMES])
def test_pages_are_in_american_english(name):
    assert found(SPELLING, said(read(name))) == []


def said_in_code(pattern, package):
    """Return all matches in docstrings and comments of a package, by file.

    Names are ignored: words beside an underscore, a backtick, a hyphen or a slash, or before a colon or parenthesis.
    """
    written = rf"(?<![\w.`\"/-])(?:{pattern})(?![\w`(:-])"
    kinds, said_so = {tokenize.COMMENT, tokenize.STRING}, {}
    for path in sorted((ROOT / package).rglob("*.py")):
        name, text = path.relative_to(ROOT).as_posix(), path.read_text()
        if not found(written, text):
            continue
        for token in tokenize.generate_tokens(io.StringIO(text).readline):
            if token.type in kinds and (token.type == tokenize.COMMENT or token.string.startswith('"""')):
                said_so[name] = said_so.get(name, []) + found(written, token.string)
    return {name: words for name, words in said_so.items() if words}


@pytest.mark.slow
@pytest.mark.parametrize("package", PACKAGES)
def test_docstrings_and_comments_are_in_american_english(package):
    assert said_in_code(SPELLING, package) == {}


@pytest.mark.parametrize("package", PACKAGES)
def test_docstrings_and_comments_use_the_words_of_the_field(package):
    if said_in_code("|".join(f"(?:{idiom})" for idiom, _ in IDIOMS), package):
        said_so = {better: said_in_code(idiom, package) for idiom, better in IDIOMS}
        pytest.fail(str({better: files for better, files in said_so.items() if files}))


@pytest.mark.parametrize("name", [*PAGES, *READMES])
def test_pages_use_the_words_of_the_field(name):
    text = said(read(name))
    said_so = {better: found(rf"\b(?:{idiom})\b", text) for idiom, better in IDIOMS}
    assert {better: words for better, words in said_so.items() if words} == {} and found(ENGINES, text) == []


@pytest.mark.parametrize("name", [*PAGES, *READMES])
def test_numbers_are_written_in_one_way(name):
    """`84%`, not `84 %`; `0.39`, not `.39`."""
    text = said(read(name))
    assert found(r"\d[ \u00a0]%", text) + found(r"(?<![\w.…/)])\.\d", text) == []


@pytest.mark.parametrize("name", [*PAGES, *READMES])
def test_pages_name_versions_and_no_commits(name):
    """Results name a version of the simulator: readers cannot see from a commit hash which matches it plays."""
    assert found(HASH, read(name)) == []


@pytest.mark.parametrize("name", MOST)
def test_pages_stay_short(name):
    assert len(PAGES[name].read_text().splitlines()) <= MOST[name]


@pytest.mark.parametrize("name", PAGES)
def test_a_generated_table_names_its_command(name):
    """The command is in the table, in its section, or in a block above the first section."""
    text = PAGES[name].read_text()
    head = " ".join(block.text for block in blocks(text.partition("\n## ")[0]))
    for table in GENERATED.finditer(text):
        section = text[text.rfind("\n## ", 0, table.start()) :].partition(table[0])
        after = re.split(r"^##", section[2], maxsplit=1, flags=re.M)[0]
        assert COMMAND.search("\n".join((head, section[0], table[1], after))), table[0][:80]


def test_the_patterns_find_what_they_are_for():
    assert found(SPELLING, "randomisation, a metre, greyish") != []
    assert found(SPELLING, "behaviours of neighbours") != [] and not found(SPELLING, "four hours of our labor")
    assert found(SPELLING, "parameters of a precise likelihood, otherwise realistic") == []
    assert found(ENGINES, "0.28 (there 0.25)") and not found(ENGINES, "there are 3 (here is why)")
    assert found(HASH, "of 24e2dca") and not found(HASH, "1000000 defaced")
    table = "## A\n\n<!-- x: y -->\n| a |\n<!-- end -->\n"
    assert not COMMAND.search(table) and len(GENERATED.findall(table)) == 1
