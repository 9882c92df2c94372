"""Behaviors that look through all 22 players: the same commands as the reference, in few rows."""

from __future__ import annotations

import numpy as np
import pytest

from regista.envs.football.scenic.domain import FOOTBALL
from regista.envs.football.scenic.world import FOOTBALL_WORLD
from scenic_lite import load
from scenic_lite.core.world import packed
from scenic_lite.dynamics.compiler import lists
from scenic_lite.dynamics.compiler.compile import compile_program
from scenic_lite.dynamics.machine.opcodes import COPY_MANY
from tests.reference.interpreter import Reference
from tests.scenic_lite.dynamics.compare import differences
from tests.scenic_lite.dynamics.controller import CompiledController
from tests.scenic_lite.dynamics.generated import program as generated
from tests.scenic_lite.dynamics.test_compiled import random_worlds

ROLES = ("GK", "CB", "LB", "RB", "DM", "CM", "LM", "RM", "AM", "CF", "CF")
BODIES = {
    "the nearest of a filtered list": """
        free = [p for p in ds.players if p is not self and (distance from self to p) < 90 and not p.owns_ball]
        if len(free) > 0:
            best = min(free, key=lambda p: distance from self to p)
            take MoveTowardsPoint(best.position, self.position)
        else:
            take Shoot()
""",
    "a helper over a filtered list": """
        free = [p for p in ds.left_players if not p.owns_ball and p.x > self.x]
        best, gap = get_closest_player_info(self, free)
        take NoAction() if best is None else MoveTowardsPoint(best.position, self.position), int(min(gap, 90)) % 19
""",
    "helpers of whoever is found": """
        other, mate = nearestOpponent(self), nearestTeammate(self)
        if opponentInRunway(other, 60) and teammateHasBallPossession(mate):
            take MoveTowardsPoint(other.position, mate.position, other.team == "right")
        take Pass("long") if opponentInRunway(self, 50) else Shoot()
""",
    "a loop over all": """
        n = 0
        last = None
        for p in ds.players:
            if p is self:
                continue
            if p.owns_ball and p.team == "left":
                n += 1
            elif (distance from p to ball) < 30:
                n += 2
                last = p
            if n > 9:
                break
        take n % 19, 0 if last is None else int(abs(last.x)) % 19
""",
    "helpers in a loop": """
        n = 0
        for p in ds.left_players:
            if (distance from p to nearestOpponent(p)) < 20:
                n += 1
                if p.role == "CB":
                    take 7
        take n
""",
    "a filter that calls helpers": """
        free = [p for p in ds.players if not opponentInRunway(p, 40) and nearestTeammate(p) is not self]
        take len(free) % 19
        far = max(ds.players, key=lambda p: distance from p to self)
        take MoveTowardsPoint(far.position, self.position)
""",
    "attributes of each": """
        for p in ds.left_players:
            p.seen = p.x
        take int(abs(ego.seen)) % 19
""",
    "sorted": """
        order = sorted(ds.right_players, key=lambda p: distance from self to p)
        ahead = [p for p in order if p.x > self.x]
        take MoveTowardsPoint(order[1].position, self.position)
        if len(ahead) > 2:
            take MoveTowardsPoint(ahead[2].position, self.position)
""",
}


def text_of(body: str) -> str:
    text = "from football.behaviors import *\nbehavior B():\n    while True:\n        ds = simulation().game_ds" + body
    for side, x in (("Left", -50), ("Right", 50)):
        for i, role in enumerate(ROLES):
            name, behavior = ("ego = ", ", with behavior B()") if (side, i) == ("Left", 5) else ("", "")
            text += f"{name}{side}{role} at {x + 3 * i} @ {3 * i - 15}{behavior}\n"
    return text + "ball = Ball at 2 @ 0\n"


@pytest.mark.long
@pytest.mark.parametrize("name", sorted(BODIES))
def test_a_behavior_among_22_players_gives_the_same_commands(name: str) -> None:
    program = load(text_of(BODIES[name]), FOOTBALL)
    compiled = compile_program(program, FOOTBALL_WORLD)
    assert len(compiled.code.rows) < 400
    theta = np.zeros(program.dim)
    players = [Reference(program, theta, FOOTBALL_WORLD, 5), CompiledController(compiled, theta, 5)]
    seen = set()
    for table, facts in random_worlds(np.random.default_rng(3), len(program.objects), 60):
        commands = [each.act(table, facts) for each in players]
        taken = [tuple(packed(each, 20) for each in found.actions if each) for found in commands]
        assert taken[0] == taken[1]
        seen.add(taken[0])
    assert len(seen) > 3


def test_a_long_list_is_copied_by_one_row() -> None:
    code = compile_program(load(text_of(BODIES["the nearest of a filtered list"]), FOOTBALL), FOOTBALL_WORLD).code
    assert COPY_MANY in code.rows[:, 0]


@pytest.mark.slow
@pytest.mark.sample(24)
@pytest.mark.parametrize("seed", range(900, 930))
def test_loops_over_objects_share_their_rows_with_the_same_commands(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lists, "MANY", 2)
    text = generated(seed)
    found, _ = differences(text, range(seed, seed + 1), steps=14)
    assert found == [], text
