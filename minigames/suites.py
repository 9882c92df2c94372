"""The minigames, as literal tuples: a training program and its test scenes.

Read next: the `.scenic` files, each at most a page; `published`, published results on these games.
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
    from easy to hard; each is also a game of its own.

    Attributes:
        control: default player of a single agent, see `FootballConfig.control`.
        rewards: recommended reward for one agent, a value of `FootballConfig.rewards`.
        team_control: values of `control` for teams of agents.
        difficulty: the reason why the game is hard, in one line.
        expert: a semi-expert program for one agent: the same players in the same order, with behaviors.
        team_expert: the same for a team.
        held_out: (label, program) pairs made by a rule, for final results only; no tuning on them.
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
        """The run settings that this game overrides, by dotted path."""
        return {"env.control": self.control, "env.rewards": self.rewards}

    def task(
        self,
        config: FootballConfig | None = None,
        program: Program | None = None,
        make: Callable[..., Any] | None = None,
    ) -> Task:
        """Return the game as a task, for `ued`'s methods or for `regista.train`.

        Args:
            config: observations, control and rewards; None: the defaults of this game.
            program: the compiled training program; None: load it.
            make: function that makes environments, `make(program, num_envs, config=config)`; None: `FootballVectorEnv`.

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
        shared = (self.control, self.rewards, self.team_control)
        return [
            Minigame(f"{self.name}/{slug(label)}", path, (), f"{self.description}: {label}", *shared)
            for label, path in self.tests
        ]


def slug(label: str) -> str:
    """Return the suffix of a test's name: `top_blocked` for "top blocked", `A` for "A: chases"."""
    return label.partition(":")[0].replace(" ", "_")


def _scenes(stem: str, *names: str) -> tuple[tuple[str, Path], ...]:
    """Return the programs `<stem>_<name>` by name, with a `_` for each space."""
    return tuple((name, HERE / f"{stem}_{slug(name)}.scenic") for name in names)


ONE_V_ONE_TESTS = _scenes("one_v_one/test", "easy", "medium", "hard")

MINIGAMES: dict[str, Minigame] = {
    game.name: game
    for game in (
        Minigame(
            "1v1Restricted",
            HERE / "one_v_one" / "restricted.scenic",
            ONE_V_ONE_TESTS,
            "a striker in front of the goal, with the keeper in between",
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
            "the path to the goal is blocked, one of two teammates is open",
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


# Games designed for curricula, with goals as the only reward: goals are rare on random levels at first, or the hard
# levels are rare.
SPARSE_REWARD: dict[str, Minigame] = {
    game.name: game
    for game in (
        Minigame(
            "Gauntlet",
            HERE / "gauntlet" / "train.scenic",
            _scenes("gauntlet/test", "near", "middle", "far", "awake"),
            "three guards on the path to the goal, each with its own range",
            difficulty="the agent must pass all guards and the keeper; at first it scores on 1 of 300 random levels",
            held_out=_scenes("gauntlet/held_out", "near", "middle", "far"),
        ),
        Minigame(
            "ThreeLines",
            HERE / "gauntlet" / "lines.scenic",
            _scenes("gauntlet/test_lines", "near", "middle", "far"),
            "a guard in each of three lines across the pitch; the striker starts before or behind any of them",
            difficulty="1 of 6 random levels starts beyond the last line; in the others the agent must pass a guard",
        ),
        Minigame(
            "Pursuit",
            HERE / "gauntlet" / "pursuit.scenic",
            _scenes("gauntlet/test_pursuit", "near", "middle", "far"),
            "three defenders on the path to the goal run at the ball, each at its own speed",
            difficulty="defenders range from static to fast; at first the agent scores on 1 of 100 random levels",
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
            "six guards anywhere between the striker and an empty goal, each with its own range",
            difficulty="most random levels leave a free path; levels without one are very rare",
            held_out=_scenes("gauntlet/held_out_crowd", "wall", "bends", "trap"),
        ),
        Minigame(
            "1v1Rare",
            HERE / "one_v_one" / "rare.scenic",
            ONE_V_ONE_TESTS,
            "a striker and a keeper off the striker's path; in 1 of 50 levels the keeper blocks the path",
            difficulty="a strategy for the common levels is learned quickly; the rare levels require another one",
            held_out=_scenes("one_v_one/held_out_restricted", "in", "clear"),
        ),
        Minigame(
            "1v1RareLine",
            HERE / "one_v_one" / "rare_line.scenic",
            _scenes("one_v_one/test_rare", "out", "line", "line wide"),
            "a striker and a keeper off the line and the path; in 1 of 50 levels the keeper is on the line",
            difficulty="as 1v1Rare: a strategy for the common levels is learned quickly, and fails on the rare ones",
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
            difficulty="far from the goal there is no learning signal until the agent has learned to score near it",
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
            difficulty="teammates and defenders anywhere: the cross must find a gap",
        ),
    )
}


def _page(name: str, description: str, difficulty: str, tested: bool = True, **others: Any) -> Minigame:
    """Return the game of program `<name>`, with test `<name>_test`."""
    tests = (("test", HERE / f"{name}_test.scenic"),) if tested else ()
    return Minigame(name, HERE / f"{name}.scenic", tests, description, difficulty=difficulty, **others)


EXPERTS = HERE / "experts"
ATTACK: dict[str, Any] = {"team_control": ("allNonGK",)}
DEFENCE: dict[str, Any] = {"team_control": ("all",)}

# The 22 games of Scenic4RL, with its positions and behaviors; one agent moves the player closest to the ball.
BENCHMARK: dict[str, Minigame] = {
    game.name: game
    for game in (
        _page(
            "offense/avoid_pass_shoot",
            "a defender between the ball carrier and the goal, a teammate behind the defender",
            "quickly memorized; the policy fails for other starting positions",
            expert=EXPERTS / "avoid_pass_shoot.scenic",
            team_expert=EXPERTS / "team_avoid_pass_shoot.scenic",
            **ATTACK,
        ),
        _page(
            "offense/easy_crossing",
            "the ball wide in the box, a teammate on the other side, a defender in between",
            "quickly learned from the ball's position; poor generalization to the other side",
            **ATTACK,
        ),
        _page(
            "offense/hard_crossing",
            "a winger at the sideline, two teammates among three defenders",
            "the cross must reach a teammate between three defenders",
            **ATTACK,
        ),
        _page(
            "offense/11_vs_gk",
            "eleven against a keeper, from the kick-off spot",
            "ninety meters without a learning signal: with goals as the only reward, 1 run in 10 learns",
            rewards=CHECKPOINTS,
            team_control=("2", "3"),
            expert=EXPERTS / "11_vs_gk.scenic",
            team_expert=EXPERTS / "team_11_vs_gk.scenic",
        ),
        _page(
            "offense/vision",
            "a long pass to one of two forwards; a distant defender decides who is onside",
            "the decisive player is far from the ball; 44 parameters",
            rewards=CHECKPOINTS,
            **ATTACK,
        ),
        _page(
            "defense/gk_vs_opponent",
            "a keeper alone against an attacker",
            "the easiest defense",
            **DEFENCE,
        ),
        _page(
            "defense/2vs2",
            "two defenders against two attackers, empty goal",
            "the agent must win the ball before the shot; tests start much closer to the ball",
            **DEFENCE,
        ),
        _page(
            "defense/2vs2_counterattack",
            "a counterattack of two attackers over the wing, empty goal",
            "a teammate waits between the agent and its goal",
            **DEFENCE,
        ),
        _page(
            "defense/2vs2_high_pass",
            "a high pass from the wing to an attacker in front of the box",
            "the controlled player changes while the ball is in the air",
            **DEFENCE,
        ),
        _page(
            "defense/3vs2_counterattack",
            "a counterattack of two attackers against one defender, with two teammates running back",
            "two against one until the teammates are back",
            **DEFENCE,
        ),
        _page(
            "defense/3vs3_cross_from_side",
            "a cross to one of two attackers in front of the goal",
            "winning the ball does not end the episode; only a goal or the ball out of play does",
            **DEFENCE,
        ),
        _page(
            "defense/3vs3_side_buildup",
            "three against three from the side, empty goal",
            "no player is behind the three defenders: every shot scores",
            **DEFENCE,
        ),
        _page(
            "defense/hesitant_dribble",
            "a single defender against the built-in attacker, empty goal",
            "one duel in front of an empty goal; the hardest of the published defenses",
            **DEFENCE,
        ),
        _page(
            "defense/zigzag_dribble",
            "a defender and a static keeper against an attacker who dribbles around them",
            "the attacker reacts early; in the tests it starts a few meters from the defender and reacts late",
            **DEFENCE,
        ),
        _page("grf/empty_goal", "the ball in midfield, no opponents", "fifty meters of running", **ATTACK),
        _page("grf/empty_goal_close", "the ball in the box, no opponents", "turn and shoot", **ATTACK),
        _page(
            "grf/run_to_score",
            "an empty goal ahead, five chasers behind",
            "sprint straight ahead; in the test the path is not straight",
            rewards=CHECKPOINTS,
            **ATTACK,
        ),
        _page(
            "grf/run_to_score_with_keeper",
            "the keeper ahead, five chasers behind",
            "the agent must beat the keeper; published agents learn nothing from goals only",
            rewards=CHECKPOINTS,
            expert=EXPERTS / "run_to_score.scenic",
            **ATTACK,
        ),
        _page(
            "grf/pass_and_shoot_with_keeper",
            "the ball carrier wide and marked, a teammate open in front of the goal",
            "pass at once; the test is mirrored",
            expert=EXPERTS / "pass_and_shoot.scenic",
            team_expert=EXPERTS / "team_pass_and_shoot.scenic",
            **ATTACK,
        ),
        _page(
            "grf/run_pass_and_shoot_with_keeper",
            "the ball carrier wide and open, a defender on the passing lane",
            "dribble to the goal, or pass behind the defender",
            **ATTACK,
        ),
        _page(
            "grf/3_vs_1_with_keeper",
            "three attackers in front of the box against a defender and the keeper",
            "shoot, or pass to either side",
            tested=False,
            **ATTACK,
        ),
        _page(
            "grf/counterattack_easy",
            "eleven a side, five attackers ahead of most opponents",
            "eleven opponents; published agents learn nothing from goals only",
            tested=False,
            rewards=CHECKPOINTS,
            team_control=("3",),
            expert=EXPERTS / "counterattack.scenic",
            team_expert=EXPERTS / "team_counterattack.scenic",
        ),
    )
}

# The academy of Google Research Football, with the starting positions and rules of its scenario files.
ACADEMY: dict[str, Minigame] = {
    f"academy/{name}": Minigame(f"academy/{name}", HERE / "academy" / f"{name}.scenic", (), description, "active")
    for name, description in (
        ("empty_goal_close", "the ball in the box, no opponents"),
        ("empty_goal", "the ball in midfield, no opponents"),
        ("run_to_score", "five chasers behind, an empty goal ahead"),
        ("run_to_score_with_keeper", "five chasers behind, the keeper ahead"),
        ("pass_and_shoot_with_keeper", "the ball carrier wide and marked, a teammate open in the middle"),
        ("run_pass_and_shoot_with_keeper", "the ball carrier wide and open, a teammate marked in the middle"),
        ("3_vs_1_with_keeper", "three attackers at the edge of the box against one defender and the keeper"),
        ("counterattack_easy", "eleven a side, five attackers ahead of most opponents"),
    )
}

# Named mixtures, from easy to hard, on which one run trains; write other mixtures as names joined by +.
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
# All names accepted as a program: games, and their test scenes as `<game>/<test>`.
NAMED = ALL | {test.name: test for game in ALL.values() for test in game.test_games()}
