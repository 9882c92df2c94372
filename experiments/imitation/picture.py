"""The picture of behavior cloning: losses over epochs, and accuracy by action.

Read next: `commands.clone`; `pictures.plots`, the style.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from regista.envs.football.constants import ACTION_NAMES
from regista.experiments.pictures import plots
from regista.experiments.run.table import read_columns

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ued.learning.cloning import Agreement

TRAINED, HELD_OUT = plots.FAINT, plots.REFERENCE


def draw_cloning(table: Path, agreement: Agreement, path: Path) -> None:
    """Draw the table of `clone` and the accuracy of its best epoch. Raises `CommandError` for a damaged table."""
    from matplotlib import pyplot

    columns = read_columns(table)
    with plots.style():
        figure, (losses, accuracies, actions) = pyplot.subplots(1, 3, figsize=(12, 3.6), layout="constrained")
        epochs = columns["update"]
        losses.plot(epochs, columns["loss"], color=TRAINED, label="training")
        losses.plot(epochs, columns["held_out/loss"], color=HELD_OUT, label="held out")
        losses.set(title="negative log-likelihood of the actions", xlabel="epoch")
        losses.legend()
        accuracies.plot(epochs, columns["held_out/accuracy"], color=HELD_OUT, label="all steps")
        accuracies.plot(epochs, columns["held_out/balanced_accuracy"], color=TRAINED, label="mean over actions")
        accuracies.set(title="held-out accuracy", xlabel="epoch")
        plots.rate_axis(accuracies)
        accuracies.legend()
        _bars(actions, agreement)
        plots.save(figure, path)


def _bars(axes: Axes, agreement: Agreement) -> None:
    from matplotlib.ticker import PercentFormatter

    done = np.flatnonzero(agreement.counts.sum(1))
    axes.barh(np.arange(len(done)), agreement.recall[done], color=HELD_OUT)
    axes.set_yticks(np.arange(len(done)), [ACTION_NAMES[action] for action in done])
    axes.invert_yaxis()
    axes.set(title="held-out accuracy by action", xlim=(0, 1))
    axes.xaxis.set_major_formatter(PercentFormatter(1.0))
