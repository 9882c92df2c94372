"""`python -m lab.paired_football`: rare branches in each order, their rows, and the table on a page."""

import sys

import pytest

from lab import paired_football
from lab.paired_football import ORDERS, Cell, Part, order_part, publish, table
from regista.experiments.run.table import read_rows


def row(order, variant, seed, held_out):
    return {"game": "1v1Rare", "order": order, "variant": variant, "seed": str(seed), "simulator": "1"} | {
        "env_steps": "4000000",
        "held_out": str(held_out),
        "scene_0": str(held_out + 5),
        "scene_1": str(held_out - 5),
        "rare_share_4": "0.25" if variant == "paired" else "",
    }


def test_the_table_has_even_branches_and_plr_beside_paired_for_each_order():
    cells = [(cell.order, cell.variant) for cell in order_part() if cell.game == "1v1Rare"]
    assert cells[:2] == [("first", "dr"), ("even", "dr, even branches")]
    assert cells[2:] == [(order, method) for method in ("paired", "plr") for order in ORDERS]


def test_differences_are_to_the_first_setting_and_marked(tmp_path):
    rows = [row("first", "dr", seed, 40 + seed) for seed in range(5)]
    rows += [row("last", "paired", seed, 70 + seed) for seed in range(5)]
    text = table(rows)
    head, _, dr, paired, *_ = text.splitlines()
    assert head == (
        "| game | order | setting | runs | held-out success | first scene | second scene "
        "| rare option in proposals | minus dr |"
    )
    assert dr.startswith("| 1v1Rare | first | dr | 5 | 42 [") and dr.endswith("|  |  |")
    assert paired.startswith("| 1v1Rare | last | paired | 5 | 72 [") and "| 25 [25, 25] | +30 [" in paired
    assert paired.endswith("] * |") and "4.0M env steps" in text and text.endswith("Simulator version 1.")
    page = tmp_path / "page.md"
    page.write_text("# A\n<!-- rare: order -->\nold\n<!-- end -->\n## B\n")
    publish("order", text, page)
    assert page.read_text() == f"# A\n<!-- rare: order -->\n{text}\n<!-- end -->\n## B\n"
    with pytest.raises(SystemExit, match=r"page.md has no '<!-- rare: settings -->'"):
        publish("settings", text, page)


@pytest.mark.slow
def test_a_part_is_trained_and_its_rows_are_kept(tmp_path, monkeypatch, capsys):
    short = {"num_envs": 4, "ppo.num_steps": 512}
    cells = [Cell("1v1Rare", "first", "dr", "dr", short), Cell("1v1Rare", "last", "paired", "paired", short)]
    monkeypatch.setattr(paired_football, "PARTS", {"order": Part(cells, range(1), 8192)})
    monkeypatch.setattr(paired_football, "EPISODES", 4)
    path = tmp_path / "order.csv"
    monkeypatch.setattr(sys, "argv", ["", "order", "--csv", str(path), "--out", str(tmp_path / "runs")])
    paired_football.main()
    rows = read_rows(path)
    assert [(row["order"], row["variant"], row["scenes"]) for row in rows] == [
        ("first", "dr", "in; clear"),
        ("last", "paired", "in; clear"),
    ]
    assert "| 1v1Rare | last | paired | 1 |" in capsys.readouterr().out
