"""The table of methods. A method is one file of this folder and one row of `METHODS`.

The command line, `docs/methods.md`, the pictures and `from ued import ...` read this table, which needs no torch.
Read next: `methods.dr`, then `methods.paired`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import Any

from ued import config


@dataclass(frozen=True)
class MethodRow:
    """A row of the table of methods, available without loading torch.

    Attributes:
        name: `regista train --method NAME`, and the prefix of its settings: `--name.setting`.
        module: the file that holds it.
        class_name: the class in it, made with (upomdp, ppo, settings, seed).
        settings: function that creates its default settings.
        title, color: name and color in all figures.
        paper: its source, or – without a source.
        help: one line on how it chooses levels.
        steps: simulated steps per step that the student learns from, with the default settings.
        settings_of: the method whose settings it shares, if any.
        marker: Matplotlib's name of the marker of its curves.
    """

    name: str
    module: str
    class_name: str
    settings: Callable[[], Any]
    title: str
    color: str
    paper: str
    help: str
    steps: str
    settings_of: str = ""
    marker: str = "o"

    @property
    def group(self) -> str:
        """The name under which its settings are kept."""
        return self.settings_of or self.name

    def load(self) -> Any:
        """Return its class, which loads torch."""
        return getattr(import_module(self.module), self.class_name)


# fmt: off
METHODS = {row.name: row for row in (  # tests/experiments/test_colors.py checks the colors
    MethodRow(
        "dr", "ued.methods.dr", "DR", config.DRConfig, "domain randomization", "#5a69a5", "Tobin et al. 2017",
        "a random level for every episode", "1",
    ),
    MethodRow(
        "minimax", "ued.methods.minimax", "Minimax", config.MinimaxConfig, "minimax", "#6f2c02", "Dennis et al. 2020",
        "an adversary lowers the student's return", "1", marker="X",
    ),
    MethodRow(
        "paired", "ued.methods.paired", "Paired", config.PairedConfig, "PAIRED", "#965a00", "Dennis et al. 2020",
        "an adversary maximizes a protagonist's regret",
        "2, for the protagonist", marker="s",
    ),
    MethodRow(
        "paired_literal", "ued.methods.paired_literal", "PairedLiteral", config.PairedLiteralConfig, "literal PAIRED",
        "#484566", "the same, to the letter",
        "students learn from regret, without entropy", "2, plus truncated episodes", marker="<",
    ),
    MethodRow(
        "self_regret", "ued.methods.self_regret", "SelfRegret", config.SelfRegretConfig, "self-regret", "#5046b6", "–",
        "an adversary maximizes a student's improvement", "1", marker="*",
    ),
    MethodRow(
        "repaired", "ued.methods.repaired", "Repaired", config.RepairedConfig, "REPAIRED", "#cb8612",
        "Jiang et al. 2021a", "PAIRED with a level buffer", "4", marker="p",
    ),
    MethodRow(
        "plr", "ued.methods.plr", "PLR", config.PLRConfig, "PLR", "#69a151", "Jiang et al. 2021b",
        "random levels, and replayed ones with high scores", "1", marker="^",
    ),
    MethodRow(
        "robust_plr", "ued.methods.plr", "RobustPLR", config.PLRConfig, "PLR⊥", "#ac6bff", "Jiang et al. 2021a",
        "PLR that learns only from replayed levels", "2", settings_of="plr", marker="D",
    ),
    MethodRow(
        "accel", "ued.methods.accel", "ACCEL", config.ACCELConfig, "ACCEL", "#830032", "Parker-Holder et al. 2022",
        "edited copies of replayed levels enter the buffer", "2.25", marker="v",
    ),
    MethodRow(
        "cenie", "ued.methods.cenie", "CENIE", config.CENIEConfig, "CENIE", "#4b00b7", "Teoh et al. 2024",
        "ACCEL, or robust PLR, by regret and novelty", "2.25", marker=">",
    ),
    MethodRow(
        "sfl", "ued.methods.sfl", "SFL", config.SFLConfig, "SFL", "#0800fa", "Rutherford et al. 2024",
        "levels that the student solves half of the time", "1 / (1 − share of candidates)", marker="P",
    ),
    MethodRow(
        "ncc", "ued.methods.ncc", "NCC", config.NCCConfig, "NCC", "#5d8a65", "Monette et al. 2025",
        "a learned distribution over a buffer of levels", "2", marker="h",
    ),
    MethodRow(
        "alp_gmm", "ued.methods.alp_gmm", "ALPGMM", config.ALPGMMConfig, "ALP-GMM", "#34357d", "Portelas et al. 2019",
        "levels with learning progress, by Gaussian mixtures", "1", marker="8",
    ),
    MethodRow(
        "lessons", "ued.methods.lessons", "Lessons", config.LessonsConfig, "lessons", "#8d3ffd", "Bengio et al. 2009",
        "ranges that you plan, lesson by lesson", "1", marker="d",
    ),
)}
# fmt: on
