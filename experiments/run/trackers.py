"""TensorBoard and Weights & Biases as reporters: `--report tensorboard wandb`. Each needs its extra.

Both write to the run folder; W&B is offline unless WANDB_MODE is set. Read next: `run.reporting`, the interface;
`docs/files.md`, the scalars.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from importlib.util import find_spec
from typing import Any

from regista.experiments.run import build
from regista.experiments.run import config as configs
from regista.experiments.run.errors import CommandError
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.reporting import Reporter, Update


class TensorBoard:
    """Event files below `tensorboard/` of the run folder; `tensorboard --logdir runs` shows all runs."""

    def __init__(self, run: RunFolder, env_steps: int) -> None:
        from torch.utils.tensorboard import SummaryWriter

        # Remove the logs of a killed run after its checkpoint
        purge = env_steps + 1 if env_steps else None
        self.writer: Any = SummaryWriter(str(run.path / "tensorboard"), purge_step=purge)

    def report(self, update: Update) -> None:
        """Log all scalars at their env_steps, and events as text."""
        for name, value in finite(update.metrics).items():
            self.writer.add_scalar(name, value, update.env_steps)
        for event in update.events:
            self.writer.add_text(f"events/{event.event}", event.text, update.env_steps)

    def flush(self) -> None:
        """Write pending data."""
        self.writer.flush()

    def close(self) -> None:
        """Close the file."""
        self.writer.close()


class WeightsAndBiases:
    """A run of the W&B project `regista`; a resumed run keeps its id. `wandb sync` uploads offline data.

    W&B accepts each step once, so it keeps the first log of a step that is repeated after a kill.
    """

    def __init__(self, run: RunFolder) -> None:
        import wandb

        config, game = run.config, build.find_game(run.config.minigame)
        self.run: Any = wandb.init(
            project="regista",
            id=run.about.get("id"),
            name=f"{game.short} {config.method} {config.seed}",
            group=f"{game.short} {config.method}",
            config={**configs.to_dict(config), "about": run.about},
            dir=str(run.path),
            resume="allow",
            mode=os.environ.get("WANDB_MODE", "offline"),
            settings=wandb.Settings(silent=True),
        )

    def report(self, update: Update) -> None:
        """Log all scalars at their env_steps, and events as alerts."""
        self.run.log(finite(update.metrics), step=update.env_steps)
        for event in update.events:
            self.run.alert(event.event, event.text)

    def flush(self) -> None:
        """Do nothing: W&B writes in its own process."""

    def close(self) -> None:
        """Finish the W&B run."""
        self.run.finish()


def make_tracker(name: str, run: RunFolder, env_steps: int) -> Reporter:
    """Return the tracker with a name; `env_steps` are logged already.

    Raises `CommandError` if it is not installed.
    """
    if find_spec(name) is None:
        raise CommandError(f"--report {name} needs an extra: pip install 'regista[{name}]'")
    return TensorBoard(run, env_steps) if name == "tensorboard" else WeightsAndBiases(run)


def finite(metrics: Mapping[str, float]) -> dict[str, float]:
    """Return the metrics that are neither nan nor infinite."""
    return {name: float(value) for name, value in metrics.items() if math.isfinite(value)}
