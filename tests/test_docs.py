"""Tests of the documentation: blocks run, link targets exist, and each picture's caption names its command.

Training is cut to a few steps. `test_contributing` follows the how-to pages for extensions.
"""

import inspect
import io
import os
import re
import runpy
import shlex
import subprocess
import sys
from contextlib import redirect_stdout, suppress
from functools import cache
from pathlib import Path

import pytest

import scenic_lite
from regista.envs.football.scenic.domain import FOOTBALL
from regista.experiments.__main__ import COMMANDS, main
from regista.experiments.commands import train
from regista.experiments.run.launch import workers
from tests.pages import ROOT, blocks, commands, dead_links, pictures, write
from tests.test_contributing import PAGES as CARRIED_OUT_ELSEWHERE

DOCS = ROOT / "docs"
PAGES = {path.relative_to(DOCS).as_posix(): path for path in sorted(DOCS.rglob("*.md"))} | {
    "README": ROOT / "README.md"
}
ALL = {path.relative_to(ROOT).as_posix(): path for path in [*sorted(ROOT.glob("*.md")), *PAGES.values()]} | {
    name: ROOT / name
    for name in (
        *("ued/README.md", "envs/football/README.md", "envs/football/DYNAMICS.md", "envs/grf/README.md"),
        *("lab/README.md", "lab/grf/data/README.md"),
    )
}
RUN = [name for name in PAGES if name.removeprefix("howto/").removesuffix(".md") not in CARRIED_OUT_ELSEWHERE]

NEEDS = {
    "howto/scenic3.md": "scenic",
    "howto/environment.md": "Box2D",
    "api.md": "pandas",
}  # optional packages

# Arguments added to the commands of a page, so that they end soon. For other commands, only the flags are checked.
BRIEF = ["--total-env-steps", "256", "--num-envs", "4", "--num-steps", "32", "--eval-every", "0"]
QUICK = {
    "train": BRIEF,
    "compare": [*BRIEF, "--no-record", "--seeds", "1", "--episodes", "2", "--levels", "0"],
    "evaluate": ["--episodes", "2", "--levels", "0", "--no-baselines"],
    "inspect": [],
    "list": [],
    "play": ["--steps", "5"],
    "demonstrate": ["--episodes", "2"],
    "clone": ["--epochs", "1"],
}
SHORTER = ((r"(env_steps(?:=| < ))[\d_]+", r"\g<1>512"), (r"episodes=\d+", "episodes=2, level_episodes=2"))
LANGUAGES = {"python", "sh", "console", "scenic"}


@cache
def flags(command):
    """Return the flags of a command, from its help."""
    shown = io.StringIO()
    with redirect_stdout(shown), suppress(SystemExit):
        main([command, "--help", "all"])
    return set(re.findall(r"(?<![\w-])--?[a-z][\w.-]*", shown.getvalue()))


def has_its_flags(words):
    """Assert that `regista WORDS` names an existing command and existing flags."""
    assert words[0] in COMMANDS or words[0].startswith("-"), words
    typed = {word for word in words if re.match(r"--?[a-z]", word)} - {"--help", "--version"}
    assert typed <= flags(words[0]), f"{words}: no {typed - flags(words[0])}"


class Reader:
    """A reader who follows a page in an empty folder.

    Attributes:
        names: the namespace of the page's Python blocks.
        records: whether training writes recordings, because the page opens one.
    """

    def __init__(self, text):
        self.names, self.records = {"__name__": "page"}, "\nrerun " in text

    def read(self, block):
        """Write the file of a block, or run the block."""
        assert block.language in LANGUAGES | {"text", "bibtex", ""}, block
        if block.where:
            write(Path(block.names[0]), block.text)
        elif block.language == "python":
            text = block.text
            for long, short in SHORTER:
                text = re.sub(long, short, text)
            exec(compile(text, "page", "exec"), self.names)
        elif block.language == "scenic":
            scenic_lite.load(block.text, FOOTBALL)
        for line in commands(block) if block.language in ("sh", "console") and not block.where else ():
            words = shlex.split(line)
            if words[0] == "regista":
                self.regista(words[1:], block.language == "sh")
            elif words[0] == "make":
                assert re.search(rf"^{words[1]}:", (ROOT / "Makefile").read_text(), re.M), line
            elif block.language == "sh":
                self.other(words)

    def regista(self, words, run):
        has_its_flags(words)
        if not run or words[0] not in QUICK or "--help" in words or "grf" in words:
            return
        extra = QUICK[words[0]]
        if words[0] == "train":
            extra = extra[:2] if "--resume" in words else extra + ["--no-record"] * (not self.records)
        if "--replay" in words:
            extra = []  # the length of a recorded match is fixed
        if words[0] == "evaluate" and "--episodes" in words:
            extra = [*extra, "--level-episodes", "2"]
        assert main([*words, *extra]) == 0, words

    def other(self, words):
        if words[0] == "rerun":
            assert all(os.path.getsize(name) for name in words[1:]), words
        else:
            assert words[0] == "python", f"the tests cannot run {words}"
            runpy.run_path(words[1], run_name="__main__")


def train_here(runs, most, stop, launcher, over):
    for run in runs:
        with run.locked():
            train.train(run, stop)
        over(run)


@pytest.mark.slow
@pytest.mark.sample(3)
@pytest.mark.parametrize("name", RUN)
def test_every_block_of_a_page_runs(name, tmp_path, monkeypatch, capsys):
    if name in NEEDS:
        pytest.importorskip(NEEDS[name], reason=f"the page needs {NEEDS[name]}")
    text = PAGES[name].read_text()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(workers, "train_all", train_here)
    monkeypatch.setattr(sys, "path", [*sys.path])
    for path in ("minigames", "examples"):  # pages start in a checkout, or in a reader's own folder
        (tmp_path / path).symlink_to(ROOT / path)
    reader, known = Reader(text), set(sys.modules)
    try:
        for block in blocks(text):
            reader.read(block)
    finally:
        for module in set(sys.modules) - known:  # files of the page: another page may have the same names
            if str(tmp_path) in str(getattr(sys.modules[module], "__file__", "")):
                del sys.modules[module]


@pytest.mark.parametrize("name", ALL)
def test_links_lead_somewhere(name):
    assert dead_links(ALL[name]) == []


@pytest.mark.parametrize("name", PAGES)
def test_every_picture_names_the_command_that_makes_it(name):
    text = PAGES[name].read_text()
    for path in pictures(PAGES[name]):
        assert path.is_file()
        after = text[text.index(f"{path.name})") :].partition("\n\n")[2].partition("\n\n")[0]
        assert re.match(r"\*[^*]*`(regista|make|rerun|python) [^`]+`[^*]*\*", after), f"{path.name}: {after}"


@pytest.mark.long
def test_the_site_is_built_without_a_complaint(tmp_path):
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(tmp_path / "site")]
    offline = {"http_proxy": "http://127.0.0.1:9", "https_proxy": "http://127.0.0.1:9", "NO_MKDOCS_2_WARNING": "1"}
    done = subprocess.run(command, cwd=ROOT, env=os.environ | offline, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    fetched = r'<(?:script|link|img|iframe)[^>]*(?:src|href)="(?:https?:)?//[^"]*"'
    for page in (tmp_path / "site").rglob("*.html"):
        assert re.findall(fetched, page.read_text()) == [], page.name
        assert "javascripts/iframe-worker.js" in page.read_text(), f"{page.name}: no search in a folder"
    index = (tmp_path / "site" / "search" / "search_index.js").read_text()
    assert index.startswith("var __index = {") and "howto/coming-from.html" in index
    api = re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", (tmp_path / "site" / "api.html").read_text()))
    assert re.search(
        r"Returns: Type Description Path the run folder\. Raises: Type Description UsageError unknown names", api
    )
    assert re.search(r"-&gt; int .{,600}Returns: Type Description int the seed of an episode", api)
    notebook = (tmp_path / "site" / "source" / "examples" / "football_curriculum.ipynb.html").read_text()
    assert notebook.count('src="data:image/png;base64,') == 2 and notebook.count('src="data:image/gif;base64,') == 1
    assert "free parameters" in notebook and "[the minigames](" not in notebook.lower()  # output; rendered links


def test_summaries_that_return_become_sections():
    sections = runpy.run_path(str(DOCS / "sections.py"))["with_returns"]
    assert sections("Return x: `[k]`.\n\nMore.") == "More.\n\nReturns:\n    : x: `[k]`."
    raises = "Raises:\n    ValueError: no."
    assert sections(f"Play; return y.\n\n{raises}") == f"Play; return y.\n\nReturns:\n    : y.\n\n{raises}"
    for kept in ("Learn nothing.", "Return x.\n\nReturns:\n    z."):
        assert sections(kept) == kept


def test_every_page_is_in_the_contents():
    contents = (ROOT / "mkdocs.yml").read_text().partition("\nnav:")[2]
    assert [name for name in PAGES if name != "README" and name not in contents] == []


def test_python_has_every_name_that_is_offered():
    import ued

    page = (DOCS / "api.md").read_text()
    shown = set(re.findall(r"[\w.]+", page))
    homes = ued._homes()
    whole = {"ued.config", *(row.module for row in ued.METHODS.values())}  # the page shows all names of these modules
    missing = [name for name, home in homes.items() if home not in shown or (name not in shown and home not in whole)]
    assert missing == []


def test_the_table_of_classes_is_whole():
    import ued

    table = (DOCS / "api.md").read_text().partition("## ")[0]
    shown = set(re.findall(r"\[`(\w+)`\]\[", table))
    classes = {name for name in ued.__all__ if inspect.isclass(getattr(ued, name)) and not name.endswith("Config")}
    assert classes - shown == set()
