"""Every example of the language reference does what the comments in it promise."""

import re

import pytest
from manual import MANUAL, Block, blocks, failures

from regista.experiments.__main__ import main
from scenic_lite import ScenicError, load

TEXT = MANUAL.read_text()
BLOCKS = blocks(TEXT)
EXAMPLES = [pytest.param(block, id=f"line{block.line}") for block in BLOCKS if not block.file]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return the modules that examples import."""
    folder = tmp_path_factory.mktemp("manual")
    for block in BLOCKS:
        if block.file:
            (folder / block.file).write_text(block.text)
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("block", EXAMPLES)
def test_the_example_does_what_it_promises(block, folder):
    assert not (said := failures(block, folder)), "\n".join(said)


def test_there_are_many_examples():
    assert len(EXAMPLES) >= 60


def test_every_example_is_of_a_language_that_is_run():
    languages = {line[3:].split(" ")[0] for line in TEXT.splitlines() if line.startswith("```")} - {""}
    assert languages <= {"scenic", "python", "sh", "text"}


def test_an_error_looks_as_it_is_shown():
    (shown,) = re.findall(r"^```text\n(.*?)^```", TEXT, re.M | re.S)
    with pytest.raises(ScenicError) as caught:
        load("ego = Object at 0 @ 0\nb = Object at 1 @ 2, ahead ego by 3")
    assert str(caught.value) == shown.rstrip("\n")


def test_links_lead_to_headings():
    headings = {line.lstrip("# ").lower().replace(" ", "-") for line in TEXT.splitlines() if line.startswith("#")}
    links = re.findall(r"\]\(#([^)]+)\)", TEXT)
    assert links and set(links) <= headings


def test_commands_have_the_flags_that_are_shown(capsys):
    shown = re.findall(r"^regista inspect ([^#\n]*)", TEXT, re.M)
    with pytest.raises(SystemExit):
        main(["inspect", "--help"])
    assert shown and set(re.findall(r"--[a-z]+", " ".join(shown))) <= set(
        re.findall(r"--[a-z]+", capsys.readouterr().out)
    )


WRONG = [
    "ego = Object at 1 @ 2  #= (1, 3)",
    "ego = Object facing 1  #= (0, 0) facing 1 deg",
    "ego = Object at 1 @ 2  #= error: nothing",
    "ego = Object\nparam a = 1  #= 2",
    "ego = Object\nparam a = Range(0, 1)  #= D = 2",
    "ego = Object\nparam a = Range(0, 1)  #= theta a in [0, 2]",
    "ego = Object at Range(0, 4) @ 0\nrequire ego.x < 1  #= accepts 50 %",
    "ego = Object width 3  #= error: a message that is not given",
    "ego = Object at 1 @ 2  #= warning: none",
    "behavior B():\n    take 1\nego = Object with behavior B()  #= ego does 2",
    "ego = Object  #= ends at 3: reason",
    "ego = Object with width 3 @ 3\n#= (0, 0)",
    "ego = Object at 0 @ 0  #= 2: (0, 0); 3: (0, 1)",
]


@pytest.mark.parametrize("text", WRONG)
def test_a_broken_promise_is_found(text, tmp_path):
    assert failures(Block("scenic", "", 1, text), tmp_path)


@pytest.mark.parametrize(
    "text", ["1 + 1  #= 3", "1 / 0  #= error: nothing", "1 + 1  #= error: nothing", "1 / 0\n1  #= 1"]
)
def test_a_broken_promise_of_python_is_found(text, tmp_path):
    assert failures(Block("python", "", 1, text), tmp_path)


def test_an_example_without_a_promise_is_found(tmp_path):
    with pytest.raises(AssertionError, match="promises nothing"):
        failures(Block("scenic", "", 1, "ego = Object"), tmp_path)
