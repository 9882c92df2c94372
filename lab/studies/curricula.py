"""Games with their budgets, methods with their settings, and tuned settings for the studies of curricula.

A variant is a method with its own settings; the first variant of a comparison is the reference. Read next:
`lab/studies/curricula_study.py`, which trains and evaluates.

If five runs of `curricula` leave a game open, ten decide. The rule was set before any final run: a game is open if a
method's difference to DR excludes 0 but does not survive Holm's correction over the table. DR and that method then get
five more runs in that game, once: `curricula --games GAME --variants dr METHOD --seeds 10`. The table is that of the
summary, over all measured games.
"""

from __future__ import annotations

from typing import Any, NamedTuple

Settings = dict[str, Any]  # of a run, by dotted path


class Variant(NamedTuple):
    """A method and its settings that differ from the defaults."""

    method: str
    settings: Settings = {}  # noqa: RUF012 - read-only


class Comparison(NamedTuple):
    """Variants on games.

    Attributes:
        variants: by their names in tables; the first is the reference.
        games: settings of each game.
        first_seed: of the first run. Seeds below 1000 are for final tables; no run that selects a setting uses them.
        seeds: runs of each variant on each game.
        more_seeds: further runs of a variant on a game that the first ones leave open, by the rule above.
        held_out: evaluate on held-out scenes; False: on validation scenes, see `lab.studies.measuring`.
    """

    variants: dict[str, Variant]
    games: dict[str, Settings]
    first_seed: int
    seeds: int = 5
    more_seeds: int = 0
    held_out: bool = True

    @property
    def most_seeds(self) -> int:
        """The maximum number of runs of a variant on a game."""
        return self.seeds + self.more_seeds


# Few environments, long rollouts: 8,192 steps per update, as by default.
LONG: Settings = {"num_envs": 16, "ppo.num_steps": 512}


def games(env_steps: int, *names: str) -> dict[str, Settings]:
    """Return settings of games with a budget of `env_steps`."""
    return {name: {"total_env_steps": env_steps, **LONG} for name in names}


LADDER = "AcademyLadder"  # a mixture of six games
GAMES = games(
    20_000_000, "1v1Restricted", "1v1Free", "ChoosePassing", "3v2FourBehaviors", "CrossingWide", "Buildup"
) | {
    # A mixture steps its games in sequence, so many environments are three times as fast; the batch size is the same
    LADDER: {"total_env_steps": 20_000_000, "num_envs": 128, "ppo.num_steps": 64}
}

# ---------------------------------------------------------------- tuning: six settings per method, one run each


def ppo(rate: float, entropy: float) -> Settings:
    """Return settings of a learning rate and an entropy bonus."""
    return {"ppo.learning_rate": rate, "ppo.ent_coef": entropy}


def replay(group: str, score: str, **more: Any) -> Settings:
    """Return settings of a level buffer; learnability needs several episodes per level."""
    episodes = {"episodes_per_level": 4} if score == "learnability" else {}
    chosen = {"score": score, "buffer.temperature": 1.0} | episodes | more
    return {f"{group}.{name}": value for name, value in chosen.items()}


SCORES = ("max_mc", "positive_value_loss", "learnability")
PPO = ppo(0.003, 0.01)  # for all methods: DR's setting (of six) with the best mean success on validation scenes

TUNING = {
    f"dr, rate {rate:g}, entropy {entropy:g}": Variant("dr", ppo(rate, entropy))
    for rate in (0.0003, 0.001, 0.003)
    for entropy in (0.003, 0.01)
}
OWN: dict[str, dict[str, Settings]] = {
    "paired": {
        "defaults": {},
        "adversary entropy 0.1": {"paired.adversary.ent_coef": 0.1},
        "half random levels": {"paired.dr_fraction": 0.5},
        "no random levels": {"paired.dr_fraction": 0.0},
        "eight episodes": {"paired.episodes_per_level": 8},
        "roles of the paper": {"paired.roles": "dennis2020"},
    },
    "robust_plr": {
        f"{score}, temperature {temperature:g}": replay("plr", score, **{"buffer.temperature": temperature})
        for score in SCORES
        for temperature in (0.3, 1.0)
    },
    "accel": {
        f"{score}, edits of {size:g}": replay("accel", score, edit_size=size)
        for score in SCORES
        for size in (0.05, 0.2)
    },
    "sfl": {
        "defaults": {},
        "1024 candidates": {"sfl.candidates": 1024, "sfl.chosen": 256, "sfl.choose_every": 100},
        "selected 25%": {"sfl.chosen_share": 0.25},
        "selected 75%": {"sfl.chosen_share": 0.75},
        "eight episodes": {"sfl.candidate_episodes": 8},
        "256 candidates, 32 selected": {"sfl.chosen": 32},
    },
}
TUNING |= {
    f"{method}, {name}": Variant(method, PPO | settings)
    for method, mine in OWN.items()
    for name, settings in mine.items()
}

# ---------------------------------------------------------------- compared variants

REPLAY = replay("plr", "max_mc")

METHODS = {  # the best of six settings each
    "dr": Variant("dr", PPO),
    "paired": Variant("paired", PPO),
    "robust_plr": Variant("robust_plr", PPO | REPLAY),
    "accel": Variant("accel", PPO | replay("accel", "learnability", edit_size=0.2)),
    "sfl": Variant("sfl", PPO),
}

COMPARISONS = {
    "curricula": Comparison(METHODS, GAMES, first_seed=30, more_seeds=5),
    "tuning": Comparison(  # without Buildup: every setting of DR solves 3% after this budget, so it ranks no settings
        TUNING,
        games(4_000_000, "1v1Restricted", "ChoosePassing", "3v2FourBehaviors"),
        first_seed=1000,
        seeds=1,
        held_out=False,
    ),
}
