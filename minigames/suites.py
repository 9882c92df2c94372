"""The minigames, as literal tuples: a training program and the scenes on which its students are tested.

Read next: the `.scenic` files, each a page at most.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).parent


class Minigame(NamedTuple):
    """A named training program with its test scenes.

    `name`, with a `_` for a `/`, is also the Gymnasium id `regista/<name>-v0`; `tests` are (label, program) pairs, from
    easy to hard; `control` is whom agents move unless told otherwise.
    """

    name: str
    program: Path
    tests: tuple[tuple[str, Path], ...]
    description: str
    control: str = "closest1"


ONE_V_ONE_TESTS = (
    ("easy", HERE / "one_v_one" / "test_easy.scenic"),
    ("medium", HERE / "one_v_one" / "test_medium.scenic"),
    ("hard", HERE / "one_v_one" / "test_hard.scenic"),
)

MINIGAMES: dict[str, Minigame] = {
    game.name: game
    for game in (
        Minigame(
            "1v1Restricted",
            HERE / "one_v_one" / "restricted.scenic",
            ONE_V_ONE_TESTS,
            "a striker in front of goal, a keeper between him and it",
        ),
        Minigame(
            "1v1Free",
            HERE / "one_v_one" / "free.scenic",
            (*ONE_V_ONE_TESTS, ("restricted", HERE / "one_v_one" / "restricted.scenic")),
            "a striker and a keeper, anywhere on the right half",
        ),
        Minigame(
            "ChoosePassing",
            HERE / "choose_passing" / "train.scenic",
            (
                ("top blocked", HERE / "choose_passing" / "test_top.scenic"),
                ("bottom blocked", HERE / "choose_passing" / "test_bottom.scenic"),
            ),
            "the way to goal is closed, one of two mates is free",
        ),
        Minigame(
            "3v2FourBehaviors",
            HERE / "three_v_two" / "train.scenic",
            (
                ("A: chases the ball", HERE / "three_v_two" / "test_a.scenic"),
                ("B: marks the owner", HERE / "three_v_two" / "test_b.scenic"),
                ("C: cuts a lane", HERE / "three_v_two" / "test_c.scenic"),
                ("D: guards the goal", HERE / "three_v_two" / "test_d.scenic"),
            ),
            "three attackers against a keeper and a defender with one of four strategies",
        ),
    )
}

# Google Research Football's own academy, everybody where its scenario files have him, played as there.
ACADEMY: dict[str, Minigame] = {
    f"academy/{name}": Minigame(f"academy/{name}", HERE / "academy" / f"{name}.scenic", (), description, "active")
    for name, description in (
        ("empty_goal_close", "the ball in the box, nobody in the way"),
        ("empty_goal", "the ball in the middle, nobody in the way"),
        ("run_to_score", "five chasers behind, an empty goal ahead"),
        ("run_to_score_with_keeper", "five chasers behind, the keeper ahead"),
        ("pass_and_shoot_with_keeper", "the ball wide and marked, a mate free in the middle"),
        ("run_pass_and_shoot_with_keeper", "the ball wide and free, a mate marked in the middle"),
        ("3_vs_1_with_keeper", "three attackers at the edge of the box against one defender and the keeper"),
        ("counterattack_easy", "eleven a side, five attackers ahead of most opponents"),
    )
}
ALL = MINIGAMES | ACADEMY
