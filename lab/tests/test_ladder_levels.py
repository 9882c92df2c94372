"""The games of the mixture that teachers choose: shares of rows, tables and picture."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

from lab import ladder_levels as ladder
from lab.studies.rows import Row
from regista.experiments.run.errors import CommandError

EASY, HARD = ladder.GAMES[0], ladder.GAMES[-1]


def levels_csv(folder, levels):
    """Write a run's table of levels: (update, source, game)."""
    lines = [f"{update},{k},{source},grf/{game}" for k, (update, source, game) in enumerate(levels)]
    (folder / "levels.csv").write_text("\n".join(["update,id,source,program", *lines]) + "\n")


def row(agent, seed, part, **shares):
    return {"agent": agent, "seed": seed, "part": part} | {game: shares.get(game, 0.0) for game in ladder.GAMES}


def played(agent, seed, game, scored):
    scene = f"held out, grf/{game}"
    return Row(ladder.GAME, agent, "closest1", scene, seed, 9, 100, 0.5, 0.5, scored, 0, 5.0, 9.5, "", "1")


def test_shares_are_of_chosen_levels_alone(tmp_path):
    early = [(1, "proposed", HARD)] * 3 + [(1, "proposed", EASY), (1, "random", EASY)]
    levels_csv(tmp_path, [*early, (20, "random", EASY), (20, "replayed", HARD)])
    shares = ladder.shares_of(tmp_path)
    assert shares.shape == (ladder.PARTS, len(ladder.GAMES))
    assert shares[0, 0] == 0.25 and shares[0, -1] == 0.75 and shares[-1, -1] == 1.0
    assert np.isnan(shares[1:-1]).all()


def test_the_tables_have_means_of_the_second_half_and_differences_to_dr():
    rows = [row("sfl", seed, part, **{HARD: 0.5, EASY: 0.5}) for seed in range(5) for part in range(ladder.PARTS)]
    rows += [row("paired", seed, part, **{HARD if part > 4 else EASY: 1.0}) for seed in range(5) for part in range(10)]
    rates = {"dr": 60, "paired": 10, "sfl": 61}
    scores = [
        played(agent, seed, game, rate + seed)
        for agent, rate in rates.items()
        for seed in range(5)
        for game in ladder.GAMES
    ]
    text = ladder.text_of(rows, scores)
    lines = {line.split("|")[1].strip(): line for line in text.splitlines() if line.startswith("| ")}
    assert lines["game"].split("|")[2:4] == [" paired ", " sfl "]  # the second table has no DR: it chooses no levels
    assert "100%" in lines[f"`{HARD}`"] and "50%" in lines[f"`{HARD}`"] and "50%" not in lines[f"`{ladder.GAMES[1]}`"]
    assert "100%" in lines[ladder.ONE] and "50%" in lines[ladder.ONE]
    assert f"| `{HARD}` | 62% [" in text and "-50 [" in text and "+1 [" in text
    assert "the 12 differences of this table" in text and text.count("*") > len(ladder.GAMES)


def test_a_folder_without_runs_is_refused(tmp_path):
    with pytest.raises(CommandError, match="has no finished runs of AcademyLadder"):
        ladder.read_runs(tmp_path)


@pytest.mark.slow
@pytest.mark.drawn
def test_methods_may_have_different_numbers_of_runs(tmp_path):
    rows = [row(agent, seed, part, **{HARD: 1.0}) for agent, runs in (("paired", 3), ("sfl", 1)) for seed in range(runs)
            for part in range(ladder.PARTS)]  # fmt: skip
    ladder.draw(ladder.by_agent(rows), tmp_path / "levels.png")
    assert plt.imread(tmp_path / "levels.png").std() > 0.05
