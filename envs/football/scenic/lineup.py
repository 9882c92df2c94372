"""From a Scenic program to matches in their initial states: the player of each object, and the positions.

Read next: `vector_env`.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from regista.envs.football.constants import LEFT, MAX_PLAYERS, METRES_PER_X, METRES_PER_Y, RIGHT
from regista.envs.football.control.control_modes import count_agents
from regista.envs.football.kick_off import MatchConfig, Roster, placed, unplaced
from regista.envs.football.limits import Limits, fields_of
from regista.envs.football.scenic.domain import FACTORS, ONE_FOR_ALL, SETTINGS
from regista.envs.football.scenic.world_table import THE_BALL
from regista.envs.football.state import MATCH, TABLES
from scenic_lite import Program, Scenes, SourceSpan
from ued.core.parameters import choice_in

ROLES = {name: role for role, name in enumerate(("GK", "CB", "LB", "RB", "DM", "CM", "LM", "RM", "AM", "CF"))}
TEAMS = {"left": LEFT, "right": RIGHT}
METRES = np.array([METRES_PER_X, METRES_PER_Y])

# Default endings of programs; the defaults of academy scenarios and `MatchConfig` differ.
UNLESS_SAID = {
    "end_episode_on_score": False,
    "end_episode_on_out_of_play": False,
    "end_episode_on_possession_change": False,
}
TRIALS = 256  # number of scenes on which random settings are checked before any match
LONGEST = 1_000_000  # steps of an episode
WANTED = {
    bool: "True or False",
    int: f"a whole number of steps, 1 to {LONGEST:,}",
    float: "a number from 0 to 1",
}
MOST_FACTOR = 4.0
WANTED_FACTOR = f"a number above 0 and up to {MOST_FACTOR:g}"


class NotAMatchError(ValueError):
    """A program that does not describe a match; the message gives the place, the problem and the remedy.

    `place` is the position in the program, or None.
    """

    place: SourceSpan | None = None


def refusal(program: Program, message: str, place: SourceSpan, hint: str = "") -> NotAMatchError:
    """Return the error for a place in a program, with the line and the place underlined."""
    error = NotAMatchError(str(program.error("unsupported", message, place, hint)))
    error.place = place
    return error


class Lineup:
    """How a program's objects become players and the ball.

    Attributes:
        players: indices `[P]` into the program's objects, in the order of the match: the left team before the right
            one, keepers first, otherwise in program order.
        ball: index of the ball among the objects.
        object_to_player: for each of the O objects its index in the match, or `THE_BALL`.
        roster: teams and roles `[P]`; random roles have their values at θ = 0.
        config: the settings from the program's parameters; defaults for random settings.
        random_settings: the names of the settings that differ from match to match.
        num_agents: the number of agents of the left and of the right team.

    An `engine_spread` other than 0 replaces that of `MatchConfig`. Raises NotAMatchError, also for a `control` mode
    (see `control_modes`) that needs more players.
    """

    def __init__(
        self, program: Program, control: str = "closest1", right_control: str = "none", engine_spread: float = 0.0
    ) -> None:
        self.program = program
        kinds = [set(info.classes) for info in program.objects]
        balls = [index for index, kind in enumerate(kinds) if "Ball" in kind]
        people = [index for index, kind in enumerate(kinds) if "Player" in kind]
        if len(balls) > 1:
            place = program.objects[balls[1]].place
            raise refusal(program, f"a match needs exactly one Ball, this program has {len(balls)}", place)
        if not balls:
            raise NotAMatchError(f"{program.file}: a match needs a Ball; write ball = Ball ahead of ego by 2")
        for index in set(range(len(kinds))).difference(balls, people):
            info = program.objects[index]
            raise refusal(program, f"{info.class_name} is neither a player nor the ball", info.place)
        scene = program.instantiate(np.zeros((1, program.dim)))
        who = {index: self._who(scene, index) for index in people}
        self.ball = balls[0]
        self.players = np.array(sorted(people, key=lambda index: (who[index][0], who[index][1] != ROLES["GK"])), int)
        self.roster = Roster(
            np.array([who[index][0] for index in self.players], np.int64),
            np.array([who[index][1] for index in self.players], np.int64),
            np.argsort(np.argsort(self.players)),
        )
        self.object_to_player = np.full(len(kinds), THE_BALL)
        self.object_to_player[self.players] = np.arange(len(self.players))
        self.config = replace(_settings(program), control=control, right_control=right_control)
        if engine_spread:
            self.config = replace(self.config, engine_spread=engine_spread)
        self.random_settings = sorted((SETTINGS & set(program.param_places)) - set(program.params))
        self._random_roles = [
            (place, index)
            for place, index in enumerate(self.players)
            if not isinstance(scene.properties["role"][index], str)
        ]
        self._check_teams()
        self._check_random_settings()
        self._unplaced = unplaced(self.roster, self.config)
        self.num_agents = tuple(self._count(mode, team) for mode, team in ((control, LEFT), (right_control, RIGHT)))

    @property
    def num_players(self) -> int:
        """P, the number of players of both teams."""
        return len(self.players)

    @property
    def counts(self) -> dict[str, int]:
        """The numbers of players and agents, which limit the match's fields."""
        return {"players": self.num_players, "agents": sum(self.num_agents)}

    @cached_property
    def limits(self) -> Limits:
        """The limits of the fields of matches with this line-up."""
        any_match = placed(self._unplaced, np.zeros((1, self.num_players, 2)), np.zeros((1, 2)), [0], self.config)
        random = [f".players[{place}].role" for place, _ in self._random_roles]
        return Limits(list(fields_of(MATCH, TABLES)), self.counts, any_match.view(np.int64), random)

    @cached_property
    def longest_game(self) -> int | None:
        """The `game_duration` in steps, its maximum if random; None unless a bounded column of this name sets it."""
        if "game_duration" not in self.random_settings:
            return int(self.config.game_duration)  # type: ignore[arg-type]
        draws = self.program.draws
        column = next((k for k, draw in enumerate(draws) if draw.name == "game_duration"), None)
        if column is None or not np.isfinite(draws[column].high):
            return None
        options = choice_in(draws[column])
        ends = np.array([-1.0, 1.0]) if options is None else options.middle(np.arange(options.count))
        theta = np.repeat([np.full(len(draws), -1.0), np.full(len(draws), 1.0)], len(ends), axis=0)
        theta[:, column] = np.tile(ends, 2)  # the other columns at both ends, since options may be random, too
        return int(np.max(self.program.instantiate(theta).params["game_duration"]))

    def starts(self, theta: np.ndarray, seeds: np.ndarray) -> np.ndarray:
        """Make the matches MATCH `[N]` that θ `[N, D]` describes, with streams from `seeds` `[N]`."""
        return self.starts_of(self.program.instantiate(theta), np.arange(len(theta)), seeds)

    def starts_of(self, scenes: Scenes, rows: np.ndarray, seeds: np.ndarray) -> np.ndarray:
        """Make the matches MATCH `[k]` of the scenes `rows` `[k]`, with streams from `seeds` `[k]`."""
        positions = scenes.positions[rows] * METRES
        matches, config = self._unplaced, self.config
        if self.random_settings or self._random_roles:
            drawn: dict[str, Any] = {name: self._setting(name, scenes, rows) for name in self.random_settings}
            config = replace(config, **drawn)
            roles = np.tile(np.asarray(self.roster.roles), (len(positions), 1))  # [k, P]
            for place, index in self._random_roles:
                roles[:, place] = [self._role(role, index) for role in scenes.properties["role"][index][rows]]
            matches = unplaced(replace(self.roster, roles=roles), config, len(positions))
        return placed(matches, positions[:, self.players], positions[:, self.ball], seeds, config)

    def _setting(self, name: str, scenes: Scenes, rows: np.ndarray) -> np.ndarray:
        """Return a random setting of the scenes `rows` `[k]`. Raises NotAMatchError for an invalid value."""
        kind, values = type(getattr(MatchConfig(), name)), np.asarray(scenes.params[name])[rows]
        wrong = next((value for value in values.tolist() if not _fits(value, kind, name)), None)
        if wrong is not None:
            hint = f"write param {name} = DiscreteRange(low, high)" if kind is int and type(wrong) is float else ""
            message, place = (
                f"param {name} must be {_wanted(kind, name)}, not {wrong!r}",
                self.program.param_places[name],
            )
            raise refusal(self.program, message, place, hint)
        return values.astype(kind)

    def _check_random_settings(self) -> None:
        """Raise NotAMatchError if a random setting is invalid in some scenes, judging by a few of them."""
        if self.random_settings:
            rng = np.random.default_rng(0)
            trial = rng.uniform(-1.0, 1.0, (TRIALS, self.program.dim))  # half of them at the bounds
            trial[: TRIALS // 2] = np.sign(trial[: TRIALS // 2])
            scenes = self.program.instantiate(trial)
            for name in self.random_settings:
                self._setting(name, scenes, np.flatnonzero(scenes.ok))

    def _who(self, scene: Scenes, index: int) -> tuple[int, int]:
        """Return the team and role of one object."""
        info = self.program.objects[index]
        team, role = (scene.properties.get(prop, {index: None})[index] for prop in ("team", "role"))
        if not isinstance(team, str) or team not in TEAMS:
            side = "in a random team" if isinstance(team, np.ndarray) else "in no team"
            raise refusal(self.program, f"{info.class_name} is {side}", info.place, "use a Left... or Right... class")
        return TEAMS[team], self._role(role[0] if isinstance(role, np.ndarray) else role, index)

    def _role(self, role: Any, index: int) -> int:
        """Return the number of an object's role. Raises NotAMatchError for an unknown role."""
        if not isinstance(role, str) or role not in ROLES:
            info, hint = self.program.objects[index], f"give it one of {', '.join(ROLES)}"
            raise refusal(self.program, f"{info.class_name} has the role {role!r}", info.place, hint)
        return ROLES[role]

    def _count(self, mode: str, team: int) -> int:
        members = np.asarray(self.roster.teams) == team
        roles = np.asarray(self.roster.roles)[members]
        drawn = next((index for place, index in self._random_roles if members[place]), None)
        if drawn is not None and mode == "allNonGK":
            hint = "control 'allNonGK' leaves out the keeper: write LeftGK, LeftCB, ..."
            info = self.program.objects[drawn]
            raise refusal(self.program, f"{info.class_name} has a random role", info.place, hint)
        try:
            return count_agents(mode, roles, team)
        except ValueError as error:
            raise NotAMatchError(f"{self.program.file}: {error}") from error

    def _check_teams(self) -> None:
        teams = np.asarray(self.roster.teams)
        if self.config.control != "none" and not (teams == LEFT).any():
            raise NotAMatchError(f"{self.program.file}: agents play on the left, and this program has no left player")
        for name, team in TEAMS.items():
            count = int((teams == team).sum())
            if count > MAX_PLAYERS // 2:
                raise NotAMatchError(
                    f"{self.program.file}: {count} {name} players; a team has at most {MAX_PLAYERS // 2}"
                )


def _settings(program: Program) -> MatchConfig:
    """Return the settings among the parameters of a program. Raises NotAMatchError at the place of an invalid value."""
    chosen = {name: place for name, place in program.param_places.items() if name in SETTINGS}
    for name, place in chosen.items():
        kind = type(getattr(MatchConfig(), name))
        if name not in program.params:
            if name not in ONE_FOR_ALL:
                continue
            value = "a random value: it defines success in all matches of a program"
        elif not _fits(program.params[name], kind, name):
            value = repr(program.params[name])
        else:
            continue
        hint = f"its caller set it, as --param {name}={value} does" if name in program.fixed_params else ""
        raise refusal(program, f"param {name} must be {_wanted(kind, name)}, not {value}", place, hint)
    return MatchConfig(**UNLESS_SAID | {name: program.params[name] for name in chosen if name in program.params})


def _fits(value: Any, kind: type, name: str) -> bool:
    if kind is bool or not isinstance(value, int | float) or isinstance(value, bool):
        return kind is bool and isinstance(value, bool)
    if kind is int:
        return 1 <= value <= LONGEST and float(value).is_integer()
    return 0 < value <= MOST_FACTOR if _is_factor(name) else 0 <= value <= 1


def _wanted(kind: type, name: str) -> str:
    return WANTED_FACTOR if _is_factor(name) else WANTED[kind]


def _is_factor(name: str) -> bool:
    return name in FACTORS and name != "sticky_noise"  # sticky_noise is a probability
