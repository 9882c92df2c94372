"""The minigames, as literal tuples: a training program and the scenes on which its students are tested.

Read next: the `.scenic` files, each a page at most; `published`, what others have measured on them.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from regista.envs.football.config import FootballConfig
    from scenic_lite import Program
    from ued.core.task import Task

HERE = Path(__file__).parent
CHECKPOINTS = "scoring,checkpoints"


class Minigame(NamedTuple):
    """A named training program with its test scenes; `task()` makes it a `ued.Task`.

    `name`, with a `_` for each `/`, is also the Gymnasium id `regista/<name>-v1`; `tests` are (label, program) pairs,
    from easy to hard, each a game of its own, too.

    Attributes:
        control: whom one agent moves unless told otherwise.
        rewards: what he is best paid for, a name of `FootballConfig.rewards`.
        team_control: whom several agents move, each of these ways.
        difficulty: what makes it hard, in a line.
        expert: a semi-expert program that plays it with one agent: the same players in the same order, with behaviors.
        team_expert: the same for a team.
        held_out: (label, program) pairs made by a rule, for final tables alone: nothing is tuned on them.
    """

    name: str
    program: Path
    tests: tuple[tuple[str, Path], ...]
    description: str
    control: str = "closest1"
    rewards: str = "scoring"
    team_control: tuple[str, ...] = ()
    difficulty: str = ""
    expert: Path | None = None
    team_expert: Path | None = None
    held_out: tuple[tuple[str, Path], ...] = ()

    @property
    def defaults(self) -> dict[str, Any]:
        """The settings of a run that this game changes, by dotted path."""
        return {"env.control": self.control, "env.rewards": self.rewards}

    def task(
        self,
        config: FootballConfig | None = None,
        program: Program | None = None,
        make: Callable[..., Any] | None = None,
    ) -> Task:
        """Return the game as a task, for `ued`'s methods or for `regista.train`.

        Args:
            config: what agents observe, control and are rewarded for; None: as the game's row has it.
            program: the compiled training program; None: it is loaded.
            make: makes environments of a program, `make(program, num_envs, config=config)`; None: `FootballVectorEnv`.

        Raises `ScenicError` for a program that cannot be loaded.
        """
        from regista.envs.football.config import FootballConfig
        from regista.envs.football.scenic.domain import FOOTBALL
        from regista.envs.football.task import football_task
        from regista.envs.football.vector_env import FootballVectorEnv
        from scenic_lite import load

        config = config or FootballConfig(control=self.control, rewards=self.rewards)
        program = program or load(self.program, FOOTBALL, config.dialect)
        return football_task(program, dict(self.tests), dict(self.held_out), config, make or FootballVectorEnv)

    def test_games(self) -> list[Minigame]:
        """Return each test scene as a game of its own, without tests."""
        told = (self.control, self.rewards, self.team_control)
        return [
            Minigame(f"{self.name}/{slug(label)}", path, (), f"{self.description}: {label}", *told)
            for label, path in self.tests
        ]


def slug(label: str) -> str:
    """Return what a test is called behind its game's name: `top_blocked` of "top blocked", `A` of "A: chases"."""
    return label.partition(":")[0].replace(" ", "_")


def _scenes(stem: str, *names: str) -> tuple[tuple[str, Path], ...]:
    """Return the pages `<stem>_<name>` by name, with a `_` for each space."""
    return tuple((name, HERE / f"{stem}_{slug(name)}.scenic") for name in names)


ONE_V_ONE_TESTS = _scenes("one_v_one/test", "easy", "medium", "hard")

MINIGAMES: dict[str, Minigame] = {
    game.name: game
    for game in (
        Minigame(
            "1v1Restricted",
            HERE / "one_v_one" / "restricted.scenic",
            ONE_V_ONE_TESTS,
            "a striker in front of goal, a keeper between him and it",
            held_out=_scenes("one_v_one/held_out_restricted", "in", "near", "clear"),
        ),
        Minigame(
            "1v1Free",
            HERE / "one_v_one" / "free.scenic",
            (*ONE_V_ONE_TESTS, ("restricted", HERE / "one_v_one" / "restricted.scenic")),
            "a striker and a keeper, anywhere on the right half",
            held_out=_scenes("one_v_one/held_out_free", "in", "near", "clear"),
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


# Games that ask for a curriculum, paid for goals alone: they hardly ever come on a random level at first, or what is
# hard is rare.
SPARSE_REWARD: dict[str, Minigame] = {
    game.name: game
    for game in (
        Minigame(
            "Gauntlet",
            HERE / "gauntlet" / "train.scenic",
            _scenes("gauntlet/test", "near", "middle", "far", "awake"),
            "three guards on the way to the goal, each with a reach of his own",
            difficulty="all guards and the keeper must be passed: a goal in three hundred random levels at first",
            held_out=_scenes("gauntlet/held_out", "near", "middle", "far"),
        ),
        Minigame(
            "ThreeLines",
            HERE / "gauntlet" / "lines.scenic",
            _scenes("gauntlet/test_lines", "near", "middle", "far"),
            "a guard in each of three lines across the pitch, the striker behind any of them or before",
            difficulty="one random level in six begins beyond the last line; the others want a guard passed",
        ),
        Minigame(
            "Pursuit",
            HERE / "gauntlet" / "pursuit.scenic",
            _scenes("gauntlet/test_pursuit", "near", "middle", "far"),
            "three defenders on the way to the goal who run at the ball, each at a pace of his own",
            difficulty="from posts to runners in small steps: a goal in a hundred random levels at first",
            held_out=_scenes("gauntlet/held_out_pursuit", "near", "middle", "far"),
        ),
        Minigame(
            "Alone",
            HERE / "gauntlet" / "alone.scenic",
            (),
            "a striker and a keeper, three defenders far behind the ball: a start for Gauntlet, ThreeLines and Pursuit",
            difficulty="learned in half a million steps",
        ),
        Minigame(
            "Crowd",
            HERE / "gauntlet" / "crowd.scenic",
            _scenes("gauntlet/test_crowd", "wall", "bends", "trap"),
            "six guards anywhere between the striker and an empty goal, each with a reach",
            difficulty="most random levels leave a way; what leaves none hardly ever comes by chance",
            held_out=_scenes("gauntlet/held_out_crowd", "wall", "bends", "trap"),
        ),
        Minigame(
            "1v1Rare",
            HERE / "one_v_one" / "rare.scenic",
            ONE_V_ONE_TESTS,
            "a striker, and a keeper aside of his way; a rare event, one level in fifty: he stands in it",
            difficulty="what wins nearly all levels is soon learned; the rare ones ask for another way to play",
            held_out=_scenes("one_v_one/held_out_restricted", "in", "clear"),
        ),
        Minigame(
            "1v1RareLine",
            HERE / "one_v_one" / "rare_line.scenic",
            _scenes("one_v_one/test_rare", "out", "line", "line wide"),
            "a striker, and a keeper who has come out aside of his way; one level in fifty: he is on his line",
            difficulty="as 1v1Rare: what wins where he is out is soon learned, and fails where he is not",
            held_out=(
                *_scenes("one_v_one/held_out_rare", "line"),
                ("out", HERE / "one_v_one" / "held_out_restricted_clear.scenic"),
            ),
        ),
        Minigame(
            "Buildup",
            HERE / "buildup" / "train.scenic",
            _scenes("buildup/test", "two", "three", "four"),
            "three attackers anywhere against up to four defenders and a keeper",
            difficulty="far from the goal there is nothing to learn from until what is near it is known",
            held_out=(("middle", HERE / "buildup" / "held_out.scenic"),),
        ),
        Minigame(
            "CrossingWide",
            HERE / "crossing" / "train.scenic",
            (
                ("hard crossing", HERE / "offense" / "hard_crossing.scenic"),
                ("other wing", HERE / "offense" / "hard_crossing_test.scenic"),
            ),
            "the hard crossing from either wing, from any distance",
            difficulty="mates and backs anywhere: the cross must find a gap",
        ),
    )
}


def _page(name: str, description: str, difficulty: str, tested: bool = True, **others: Any) -> Minigame:
    """Return the game of a page of this name, and of `<name>_test` beside it."""
    tests = (("test", HERE / f"{name}_test.scenic"),) if tested else ()
    return Minigame(name, HERE / f"{name}.scenic", tests, description, difficulty=difficulty, **others)


EXPERTS = HERE / "experts"
ATTACK: dict[str, Any] = {"team_control": ("allNonGK",)}
DEFENCE: dict[str, Any] = {"team_control": ("all",)}

# The benchmark of Scenic4RL, places and behaviors as there, one agent moving the player closest to the ball. 22 games.
BENCHMARK: dict[str, Minigame] = {
    game.name: game
    for game in (
        _page(
            "offense/avoid_pass_shoot",
            "a back between the carrier and the goal, a mate behind him",
            "soon learned by rote; what is learned fails wherever else players stand",
            expert=EXPERTS / "avoid_pass_shoot.scenic",
            team_expert=EXPERTS / "team_avoid_pass_shoot.scenic",
            **ATTACK,
        ),
        _page(
            "offense/easy_crossing",
            "the ball wide in the box, a mate on the other side, a back between",
            "soon learned from where the ball lies; little of it carries over to the other side",
            **ATTACK,
        ),
        _page(
            "offense/hard_crossing",
            "a winger by the line, two mates among three backs",
            "the cross has to find a mate between three backs",
            **ATTACK,
        ),
        _page(
            "offense/11_vs_gk",
            "eleven against a keeper, from the kick-off spot",
            "ninety metres without a goal to learn from: scoring alone teaches one run in ten",
            rewards=CHECKPOINTS,
            team_control=("2", "3"),
            expert=EXPERTS / "11_vs_gk.scenic",
            team_expert=EXPERTS / "team_11_vs_gk.scenic",
        ),
        _page(
            "offense/vision",
            "a long pass to one of two forwards, whom one far back keeps onside or does not",
            "what decides is far from the ball; 44 parameters",
            rewards=CHECKPOINTS,
            **ATTACK,
        ),
        _page(
            "defense/gk_vs_opponent",
            "a keeper alone against an attacker",
            "the easiest defence",
            **DEFENCE,
        ),
        _page(
            "defense/2vs2",
            "two backs against two attackers, the goal empty",
            "the ball must be won before the shot; tests begin much nearer to it",
            **DEFENCE,
        ),
        _page(
            "defense/2vs2_counterattack",
            "a counterattack by two over the wing, the goal empty",
            "a mate waits between the learner and his goal",
            **DEFENCE,
        ),
        _page(
            "defense/2vs2_high_pass",
            "a high pass from the wing to an attacker before the box",
            "whom the learner moves changes while the ball is in the air",
            **DEFENCE,
        ),
        _page(
            "defense/3vs2_counterattack",
            "a counterattack by two against one back, two mates running home",
            "two against one until the mates are back",
            **DEFENCE,
        ),
        _page(
            "defense/3vs3_cross_from_side",
            "a cross to one of two who wait before the goal",
            "winning the ball is not the end: only a goal or the line is",
            **DEFENCE,
        ),
        _page(
            "defense/3vs3_side_buildup",
            "three against three from the side, the goal empty",
            "nobody is behind the three: any shot counts",
            **DEFENCE,
        ),
        _page(
            "defense/hesitant_dribble",
            "a back alone against the built-in attacker, the goal empty",
            "one duel before an empty goal; the hardest defence of the published",
            **DEFENCE,
        ),
        _page(
            "defense/zigzag_dribble",
            "a back and a keeper who stands still, against an attacker who goes round",
            "he reacts from afar; in the tests he starts a few metres from the back and reacts late",
            **DEFENCE,
        ),
        _page("grf/empty_goal", "the ball in the middle, nobody in the way", "fifty metres of running", **ATTACK),
        _page("grf/empty_goal_close", "the ball in the box, nobody in the way", "turn and shoot", **ATTACK),
        _page(
            "grf/run_to_score",
            "an empty goal ahead, five chasers behind",
            "sprint straight on; elsewhere the way is not straight",
            rewards=CHECKPOINTS,
            **ATTACK,
        ),
        _page(
            "grf/run_to_score_with_keeper",
            "the keeper ahead, five chasers behind",
            "nothing is learned from goals alone, as published: the keeper must be passed",
            rewards=CHECKPOINTS,
            expert=EXPERTS / "run_to_score.scenic",
            **ATTACK,
        ),
        _page(
            "grf/pass_and_shoot_with_keeper",
            "the ball wide and marked, a mate free before the goal",
            "the pass at once; the test is its mirror image",
            expert=EXPERTS / "pass_and_shoot.scenic",
            team_expert=EXPERTS / "team_pass_and_shoot.scenic",
            **ATTACK,
        ),
        _page(
            "grf/run_pass_and_shoot_with_keeper",
            "the ball wide and free, a back on the way to the mate",
            "carry it in, or pass behind the back",
            **ATTACK,
        ),
        _page(
            "grf/3_vs_1_with_keeper",
            "three attackers before the box against a back and the keeper",
            "shoot, or pass to either side",
            tested=False,
            **ATTACK,
        ),
        _page(
            "grf/counterattack_easy",
            "eleven a side, five attackers ahead of most opponents",
            "eleven to watch, and nothing learned from goals alone, as published",
            tested=False,
            rewards=CHECKPOINTS,
            team_control=("3",),
            expert=EXPERTS / "counterattack.scenic",
            team_expert=EXPERTS / "team_counterattack.scenic",
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

# Programs of which one run trains on all, from easy to hard; any others are written as names joined by +.
MIXTURES: dict[str, tuple[str, ...]] = {
    "AcademyLadder": (
        "grf/empty_goal_close",
        "grf/empty_goal",
        "grf/run_to_score",
        "grf/pass_and_shoot_with_keeper",
        "grf/3_vs_1_with_keeper",
        "grf/run_to_score_with_keeper",
    ),
}

ALL = MINIGAMES | SPARSE_REWARD | BENCHMARK | ACADEMY
# Whatever can stand where a program is asked for: games, and each of their test scenes as `<game>/<test>`.
NAMED = ALL | {test.name: test for game in ALL.values() for test in game.test_games()}
