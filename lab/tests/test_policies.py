"""`make policies` on tiny budgets writes the files to install, in the same layout. Read next: `lab.policies`."""

import re

import pytest

from lab import policies
from regista.experiments.run import shipped
from regista.experiments.run.folder import RunFolder
from tests.floors import ROOT

PAGE = "# Games\n\n<!-- policies -->\nold\n<!-- end -->\n\nmore\n"
TINY = ["--env-steps", "256", "--episodes", "5"]


def files(folder):
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


def test_what_is_installed_is_what_is_made():
    assert set(shipped.names()) == {f"{shipped.PREFIX}{game}" for game in policies.POLICIES}
    for game, recipe in policies.POLICIES.items():
        run = RunFolder.open(shipped.FOLDER / game)
        assert run.about["command"].split()[2:] == policies.command(game, recipe)
        settings = run.config.method, run.config.total_env_steps, run.config.seed
        assert settings == (recipe.method, recipe.env_steps, policies.SEED)


@pytest.mark.slow
@pytest.mark.long
def test_policies_are_made_in_the_same_layout(tmp_path, capsys):
    page, out = tmp_path / "games.md", tmp_path / "out"
    page.write_text(PAGE)
    words = ["--runs", str(tmp_path / "runs"), "--out", str(out), "--page", str(page), *TINY]
    policies.main(words)
    assert files(out) == files(shipped.FOLDER)
    table = page.read_text()
    assert table.startswith("# Games\n\n<!-- policies -->\n| policy |") and table.endswith("<!-- end -->\n\nmore\n")
    assert re.findall(r"^\| `(shipped:[^`]+)` \|", table, re.M) == [f"shipped:{game}" for game in policies.POLICIES]
    before = (out / "maze" / "checkpoint.pt").read_bytes()
    policies.main(["maze", *words])  # its training is finished
    assert (out / "maze" / "checkpoint.pt").read_bytes() == before and page.read_text() == table


def test_a_game_without_a_recipe_is_refused(capsys):
    with pytest.raises(SystemExit):
        policies.main(["mazes"])
    assert "no policy is made for mazes (did you mean 'maze'?)" in capsys.readouterr().err


def test_the_page_has_the_table():
    text = (ROOT / policies.PAGE).read_text().partition("<!-- policies -->\n")[2].partition("<!-- end -->")[0]
    assert all(f"| `{name}` |" in text for name in shipped.names())
