"""`python -m lab.paired_football`: rare branches in each order, their rows, and the table on a page."""

import pytest

from lab import paired_football
from lab.paired_football import ORDERS, STUDY, Cell, Study, main
from lab.paired_football_tables import summary, table
from lab.studies import runs
from regista.experiments.run.errors import CommandError
from regista.experiments.run.report import save_rows
from regista.experiments.run.table import read_rows

KINDS = [cell[:3] for cell in STUDY.cells]


def row(order, variant, seed, held_out):
    return {"game": "1v1Rare", "order": order, "variant": variant, "seed": str(seed), "simulator": "1"} | {
        "env_steps": "4000000",
        "held_out": str(held_out),
        "scene_0": str(held_out + 5),
        "scene_1": str(held_out - 5),
        "rare_share_4": "0.25" if variant == "paired" else "",
    }


def test_the_table_has_even_branches_and_plr_beside_paired_for_each_order():
    cells = [(cell.order, cell.variant) for cell in STUDY.cells if cell.game == "1v1Rare"]
    assert cells[:2] == [("first", "dr"), ("even", "dr, equally likely options")]
    methods = ("paired", "paired, adversary entropy 0.1", "plr")
    assert cells[2:] == [(order, method) for method in methods for order in ORDERS]


def test_differences_are_to_the_first_setting_and_marked():
    rows = [row("last", "paired", seed, 70 + seed) for seed in range(5)]
    rows += [row("first", "dr", seed, 40 + seed) for seed in range(5)]
    text = table(rows, KINDS)
    head, _, dr, paired, *_ = text.splitlines()
    assert head == (
        "| game | order | setting | runs | rare scene | other scene | both scenes "
        "| rare option in proposals | minus dr, both scenes |"
    )
    assert dr.startswith("| 1v1Rare | first | dr | 5 | 47 [") and dr.endswith("|  |  |")
    assert paired.startswith("| 1v1Rare | last | paired | 5 | 77 [") and "| 25 [25, 25] | +30 [" in paired
    assert paired.endswith("] * |") and ", 4M env steps; 95% intervals: bootstrap over runs" in text
    assert " Marks: * survives Holm's correction at 5% over the one difference of this table" in text
    assert " 5 runs each: differences under 4 points cannot be detected reliably" in text
    assert text.endswith("Measured on simulator version 1; `python -m lab.paired_football`.")


def test_orders_of_a_setting_are_compared_and_even_options_are_none():
    rows = [row(order, "paired", seed, at + seed) for order, at in (("first", 40), ("last", 70)) for seed in range(5)]
    rows += [row(order, "dr, equally likely options", seed, 10 + seed) for order in ("even",) for seed in range(5)]
    text = table([*rows, *(row("first", "dr", seed, 40 + seed) for seed in range(5))], KINDS)
    assert (
        " 1 of the 1 differences between two orders of one setting survives Holm's correction; the largest is -30 ["
        in text
    )
    assert "points, of `1v1Rare`, paired, first minus last. Measured on" in text


def test_a_table_whose_reference_has_no_run_yet_has_no_differences():
    head, _, plr, *_ = table([row("last", "plr", 20, 70)], KINDS).splitlines()
    assert head.endswith("| minus dr, both scenes |") and plr == "| 1v1Rare | last | plr | 1 | 75 | 65 | 70 |  |  |"


def test_orders_of_a_seed_count_as_one_run():
    rows = [row("first", "dr", seed, 40 + seed) for seed in range(5)]
    rows += [
        row(order, "paired", seed, held_out) for seed in range(5) for order, held_out in (("first", 50), ("last", 70))
    ]
    head, _, dr, paired, *_ = summary(rows, KINDS).splitlines()
    assert head.startswith("| game | setting | runs | rare scene |") and dr.startswith("| 1v1Rare | dr | 5 | 47 [")
    assert paired.startswith("| 1v1Rare | paired | 5 | 65 [65, 65] | 55 [55, 55] | 60 [60, 60] | 25 [25, 25] | +18 [")
    assert "the one difference of this table" in summary(rows, KINDS)


def test_rows_of_another_version_or_with_other_columns_are_refused(tmp_path):
    path = tmp_path / "order.csv"
    old = dict.fromkeys(paired_football.COLUMNS, "1") | row("first", "dr", 20, 40) | {"simulator": "0"}
    save_rows([old], paired_football.COLUMNS, path)
    with pytest.raises(CommandError, match="can be neither published nor added to"):
        main(["--csv", str(path), "--table"])
    path.write_text("game,order\n1v1Rare,first\n")
    with pytest.raises(CommandError, match=r"order\.csv is damaged: its columns are game, order"):
        main(["--csv", str(path)])


@pytest.fixture
def short(tmp_path, monkeypatch):
    """Make the study two short runs for each of two seeds; return its CSV file, and the command line."""
    few = {"num_envs": 4, "ppo.num_steps": 512}
    cells = [Cell("1v1Rare", "first", "dr", "dr", few), Cell("1v1Rare", "last", "paired", "paired", few)]
    monkeypatch.setattr(paired_football, "STUDY", Study(cells, range(2), 8192))
    monkeypatch.setattr(paired_football, "EPISODES", 4)
    return tmp_path / "order.csv", ["--csv", str(tmp_path / "order.csv"), "--out", str(tmp_path / "runs")]


@pytest.mark.slow
def test_runs_are_trained_and_what_has_a_row_is_not_trained_again(short, begun, capsys):
    path, words = short
    assert main(words) == 0
    first, text = begun.copy(), path.read_text()
    assert [(row["order"], row["variant"], row["seed"], row["scenes"]) for row in read_rows(path)] == [
        (order, variant, seed, "in; clear") for order, variant in (("first", "dr"), ("last", "paired")) for seed in "01"
    ]
    assert {row["simulator"] for row in read_rows(path)} == {"1"} and len(first) == 4
    shares = [row[f"rare_share_{k}"] for row in read_rows(path) if row["variant"] == "paired" for k in range(5)]
    assert any(shares) and "nan" not in shares  # a fifth without proposals has no share
    assert "| 1v1Rare | last | paired | 2 |" in capsys.readouterr().out
    for folder in path.parent.glob("runs/*/*.pt"):
        folder.unlink()  # on another machine, only the rows exist
    assert main(words) == 0
    assert begun == first and path.read_text() == text


@pytest.mark.long
def test_a_stopped_study_keeps_each_finished_run(short, begun, monkeypatch):
    path, words = short
    usual = paired_football.measure

    def killed(run, cell):
        if run.config.seed == 0 and cell.method == "paired":
            raise KeyboardInterrupt
        return usual(run, cell)

    monkeypatch.setattr(paired_football, "measure", killed)
    with pytest.raises(KeyboardInterrupt):
        main(words)
    assert [row["variant"] for row in read_rows(path)] == ["dr"]
    monkeypatch.setattr(paired_football, "measure", usual)
    monkeypatch.setattr(runs.RunFolder, "finished", lambda run: run.env_steps() >= 8192)  # pictures are not drawn here
    assert main(words) == 0
    assert len(begun) == len(set(begun)) == 4 and len(read_rows(path)) == 4
