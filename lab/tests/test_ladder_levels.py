"""The games of the mixture that teachers choose: shares of rows, tables and picture."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

from lab import ladder_levels as ladder
from lab.studies.rows import Row
from regista.experiments.run.errors import CommandError

EASY, HARD = ladder.GAMES[0], ladder.GAMES[-1]


def write_run(folder, levels, evaluations):
    """Write the tables of a run of 20 updates of 1M steps: levels (update, source, game), success by update."""
    lines = [f"{update},{k},{source},grf/{game}" for k, (update, source, game) in enumerate(levels)]
    (folder / "levels.csv").write_text("\n".join(["update,id,source,program", *lines]) + "\n")
    head = ["update", "env_steps", *(f"eval_success/grf/{game}" for game in ladder.GAMES)]
    lines = [
        ",".join([str(k), str(k * 1_000_000), *[str(evaluations.get(k, ""))] * len(ladder.GAMES)]) for k in range(1, 21)
    ]
    (folder / "metrics.csv").write_text("\n".join([",".join(head), *lines]) + "\n")


def row(agent, seed, part, success=0.0, **shares):
    chosen = {f"share/{game}": shares.get(game, 0.0) if shares else "" for game in ladder.GAMES}
    return {"agent": agent, "seed": seed, "part": part} | chosen | dict.fromkeys(ladder.SUCCESS, success)


def played(agent, seed, game, scored):
    scene = f"held out, grf/{game}"
    return Row(ladder.LADDER, agent, "closest1", scene, seed, 9, 100, 0.5, 0.5, scored, 0, 5.0, 9.5, "", "1")


def test_shares_are_of_chosen_levels_alone_and_success_is_at_the_end_of_a_part(tmp_path):
    early = [(1, "proposed", HARD)] * 3 + [(2, "proposed", EASY), (1, "random", EASY)]
    write_run(tmp_path, [*early, (20, "random", EASY), (20, "replayed", HARD)], {1: 0.1, 4: 0.4, 20: 0.9})
    shares, success = ladder.read_run(tmp_path)
    assert shares.shape == success.shape == (ladder.PARTS, len(ladder.GAMES))
    assert shares[0, 0] == 0.25 and shares[0, -1] == 0.75 and shares[-1, -1] == 1.0
    assert np.isnan(shares[1:-1]).all()
    assert success[:, 0].tolist() == [0.1, 0.4, 0.4, 0.4, 0.4, 0.4, 0.9, 0.9, 0.9, 0.9]  # the nearest evaluation


def test_the_tables_have_choices_and_differences_to_dr():
    seeds, parts = range(5), range(ladder.PARTS)
    rows = [row("sfl", seed, part, **{HARD: 0.5, EASY: 0.5}) for seed in seeds for part in parts]
    rows += [row("paired", seed, part, 0.2, **{HARD if part > 4 else EASY: 1.0}) for seed in seeds for part in parts]
    rows += [row("dr", seed, part, part / 10) for seed in seeds for part in parts]
    rates = {"dr": 60, "paired": 10, "sfl": 61}
    scores = [played(agent, k, game, rate + k) for agent, rate in rates.items() for k in seeds for game in ladder.GAMES]
    text = ladder.text_of(rows, scores)
    assert f"| `{HARD}` | 62% [" in text and "-50 [" in text and "+1 [" in text
    assert "the 12 differences of this table" in text
    first, second, third = (block.splitlines() for block in text.split("\n\n")[::2])
    assert first[0] == "| game | dr | paired minus dr | sfl minus dr |" and len(first) == 2 + len(ladder.GAMES)
    assert second[0] == "| game | paired | sfl |"  # DR chooses no levels
    assert second[-2].startswith(f"| `{HARD}` | 100% [100, 100] | 50% [") and "| 0% [0, 0] | 50% [" in second[2]
    assert second[-1].startswith(f"| {ladder.ONE} | 100% [100, 100] | 50% [")
    assert third[2].startswith(f"| `{EASY}` | 40% [40, 40] | 20% [20, 20] | -20 [") and len(third) == len(first)
    assert "the 6 differences of this table" in text


def test_a_folder_without_runs_is_refused(tmp_path):
    with pytest.raises(CommandError, match="no finished runs of AcademyLadder"):
        ladder.read_runs(tmp_path)


@pytest.mark.slow
@pytest.mark.drawn
def test_methods_may_have_different_numbers_of_runs_and_parts(tmp_path):
    rows = [row(agent, seed, part, **{HARD: 1.0})
            for agent, runs in (("paired", 3), ("sfl", 1))
            for seed in range(runs) for part in range(5 * runs)]  # fmt: skip
    ladder.draw(ladder.by_agent(rows, ladder.SHARES), tmp_path / "levels.png")
    assert plt.imread(tmp_path / "levels.png").std() > 0.05
