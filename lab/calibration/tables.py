"""Stored measurements of GRF in drawn scenes, and the tables that are fitted to each.

Read next: `saves.py`, a table; `shots_at_keeper.py`, a measurement.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from lab.calibration import blocks, claims, curls, duels, hands, saves, shots_at_keeper, stumbles, touches
from regista.envs.football.skills.contacts import CLAIM, FEET
from regista.envs.football.skills.first_touch import AT_REST, BRING_DOWN
from regista.envs.football.skills.hands import HOLD, PARRY
from regista.envs.football.skills.passes import FLIGHT
from regista.envs.football.skills.tackles import TACKLE


@dataclass(frozen=True)
class Measurement:
    """How to measure a file of `data`: `measure(count, engine, seed)` plays `count` episodes and returns rows."""

    measure: Callable[[int, str, int], list[dict[str, Any]]]
    count: int  # episodes of GRF


@dataclass(frozen=True)
class Table:
    """A law, its fitted fields, and the losses of rows that `prepare` reads from a measurement."""

    title: str
    source: str
    law: Any
    names: tuple[str, ...]
    prepare: Callable[[Any], Any]
    losses: Callable[[Any, Any], Any]
    summary: Callable[[Any], dict[str, tuple[float, float]]]  # measured, and predicted by the shipped law
    least: float = 0.0  # lower bound of every number


MEASURES = {
    "shots_at_keeper": Measurement(shots_at_keeper.measure, 3040),
    "shots_past_back": Measurement(blocks.measure, 2400),
    "balls_at_rest": Measurement(touches.balls_at_rest, 2400),
    "passes_received": Measurement(touches.passes_received, 1200),
    "passes_kicked": Measurement(curls.passes_kicked, 1200),
    "runs_at_keeper": Measurement(claims.measure, 1600),
    "runs_at_back": Measurement(duels.measure, 320),
    "pairs_in_one_place": Measurement(stumbles.measure, 128),
}
HELD = ("fits", "surely")
TABLES = {
    "saves": Table(
        "skills/saves.py SAVE", "shots_at_keeper", saves.LAW, saves.NAMES, saves.prepare, saves.losses, saves.summary
    ),
    "held": Table(
        "skills/hands.py HOLD", "shots_at_keeper", HOLD, HELD, hands.meetings, hands.hold_losses, hands.hold_summary
    ),
    "parried": Table(
        "skills/hands.py PARRY",
        "shots_at_keeper",
        PARRY,
        ("ball", "run", "back", "along"),  # the law is the same if back, along and out are all doubled
        hands.meetings,
        hands.parry_losses,
        hands.parry_summary,
    ),
    "blocks": Table(
        "skills/blocks.py BLOCK",
        "shots_past_back",
        blocks.LAW,
        blocks.NAMES,
        blocks.prepare,
        blocks.losses,
        blocks.summary,
    ),
    "at_rest": Table(
        "skills/first_touch.py AT_REST",
        "balls_at_rest",
        AT_REST,
        ("stride_ball", "pace", "pace_turned", "pace_kept", "aside_kept"),
        touches.prepare_rest,
        touches.rest_losses,
        touches.rest_summary,
    ),
    "brought_down": Table(
        "skills/first_touch.py BRING_DOWN",
        "passes_received",
        BRING_DOWN,
        (
            "gains",
            "gains_less",
            "gains_least",
            "aside_left",
            "aside_more",
            "most",
            "ahead",
            "ahead_less",
            "ahead_least",
        ),
        touches.prepare_pass,
        touches.pass_losses,
        touches.pass_summary,
    ),
    "curl": Table(
        "skills/passes.py FLIGHT",
        "passes_kicked",
        FLIGHT,
        ("curl", "high_bend"),
        curls.prepare,
        curls.losses,
        curls.summary,
        least=-1e9,
    ),
    "claims": Table(
        "skills/contacts.py CLAIM",
        "runs_at_keeper",
        CLAIM,
        ("sure", "hurried"),
        claims.prepare_box,
        claims.claim_losses,
        claims.claim_summary,
    ),
    "feet": Table(
        "skills/contacts.py FEET",
        "runs_at_keeper",
        FEET,
        ("chance", "swerve"),
        claims.prepare_outside,
        claims.feet_losses,
        claims.feet_summary,
    ),
    "stumbles": Table(
        "physics/bodies.py STUMBLE_SPEED, STEPS_ASIDE",
        "pairs_in_one_place",
        stumbles.Stumble(),
        ("speed", "aside"),
        stumbles.prepare,
        stumbles.losses,
        stumbles.summary,
    ),
    "duels": Table(
        "skills/tackles.py TACKLE",
        "runs_at_back",
        TACKLE,
        ("built_in", "built_in_hurried", "built_in_far"),
        duels.prepare,
        duels.losses,
        duels.summary,
    ),
}
