"""How much does the loss of a family change with other random numbers alone? A profile cannot resolve less.

    python -m lab.calibration.luck                     prints the losses of all families for five sets of random numbers

`LUCK` holds these results as a share of the loss, at the efforts of the profiles. Read next: `summary.py`, which uses
it.
"""

from __future__ import annotations

import numpy as np

from lab.grf import blocks, chases, stage

# family: effort of its profiles (chases: only four sets), and standard deviation of its loss divided by the mean
LUCK: dict[str, tuple[float, float]] = {
    "passes": (2.0, 0.047),
    "shots": (0.5, 0.043),
    "keeper": (1.0, 0.122),
    "tackles": (2.0, 0.035),
    "chases": (0.5, 0.159),
    "matches": (0.5, 0.1),  # assumed, not measured
    "motion:drawn_turn_rows": (1.0, 0.057),
    "motion:slide_rows,tired_rows": (1.0, 0.0),
    "motion:start_rows,curve_rows": (1.0, 0.084),
    "motion:steady_rows,curve_rows,carry_rows": (1.0, 0.1),  # assumed, not measured
}
SETS, APART = 5, 100_003  # sets of random numbers, and the difference between their seeds


def losses(family: str, effort: float) -> list[float]:
    """Return the losses `[SETS]` of a family, each with another shift of the seeds."""
    from lab.calibration.profile import family_loss

    kick_off, play_seeds = stage.kick_off, chases.play_seeds
    found = []
    try:
        for number in range(SETS):
            shift = APART * number

            def kick_off_later(places, balls, roster, seeds, config, shift=shift):  # type: ignore[no-untyped-def]
                return kick_off(places, balls, roster, np.asarray(seeds) + shift, config)

            def play_later(program, keys, seeds, config, shift=shift):  # type: ignore[no-untyped-def]
                return play_seeds(program, keys, np.asarray(seeds) + shift, config)

            stage.kick_off, chases.play_seeds, blocks.play_seeds = kick_off_later, play_later, play_later
            found.append(family_loss(family, effort))
    finally:
        stage.kick_off, chases.play_seeds, blocks.play_seeds = kick_off, play_seeds, play_seeds
    return found


if __name__ == "__main__":
    for name, (effort_, _) in LUCK.items():
        each = losses(name, effort_)
        spread = np.std(each, ddof=1) / np.mean(each)
        print(f"{name}, effort {effort_:g}: {' '.join(f'{loss:.3f}' for loss in each)}; {spread:.3f}", flush=True)
