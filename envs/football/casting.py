"""From a Scenic program to matches about to begin: who of its objects is which player, and where everyone stands.

Read next: `vector_env`.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from envs.football.constants import LEFT, MAX_PLAYERS, METRES_PER_X, METRES_PER_Y, RIGHT
from envs.football.state import Lineup, MatchConfig, kick_off
from scenic_lite import Program, Scenes

ROLES = {name: role for role, name in enumerate(("GK", "CB", "LB", "RB", "DM", "CM", "LM", "RM", "AM", "CF"))}
TEAMS = {"left": LEFT, "right": RIGHT}
METRES = np.array([METRES_PER_X, METRES_PER_Y])

# Parameters of a program that are settings of the match.
SETTINGS = {field.name for field in dataclasses.fields(MatchConfig)} - {"learner"}


class CastingError(ValueError):
    """A program that describes no match: the message says what is missing and what would do."""


class Casting:
    """How a program's objects become players and the ball.

    Attributes:
        players: indices `[P]` into the program's objects, in the order of the match: the left team before the right
            one, keepers first, otherwise as in the program.
        ball: index of the ball among the objects.
        lineup: teams and roles `[P]`.
        config: the settings that the program's parameters make.
    """

    def __init__(self, program: Program) -> None:
        self.program = program
        kinds = [set(info.classes) for info in program.objects]
        balls = [index for index, kind in enumerate(kinds) if "Ball" in kind]
        people = [index for index, kind in enumerate(kinds) if "Player" in kind]
        if len(balls) != 1:
            raise CastingError(f"{program.file}: a match needs exactly one Ball, this program has {len(balls)}")
        scene = program.instantiate(np.zeros((1, program.dim)))
        who = {index: self._who(scene, index) for index in people}
        self.ball = balls[0]
        self.players = np.array(sorted(people, key=lambda index: (who[index][0], who[index][1] != ROLES["GK"])), int)
        self.lineup = Lineup(
            np.array([who[index][0] for index in self.players], np.int64),
            np.array([who[index][1] for index in self.players], np.int64),
        )
        self._check_teams()
        self.config = _settings(program)

    @property
    def num_players(self) -> int:
        """P, of both teams."""
        return len(self.players)

    def starts(self, theta: np.ndarray, seeds: np.ndarray) -> np.ndarray:
        """Make the matches MATCH `[N]` that θ `[N, D]` describes, with streams from `seeds` `[N]`."""
        positions = self.program.instantiate(theta).positions * METRES
        return kick_off(positions[:, self.players], positions[:, self.ball], self.lineup, seeds, self.config)

    def _who(self, scene: Scenes, index: int) -> tuple[int, int]:
        """Team and role of one object."""
        name = self.program.objects[index].class_name
        team, role = (scene.properties.get(prop, {index: None})[index] for prop in ("team", "role"))
        if not isinstance(team, str) or team not in TEAMS:
            raise CastingError(f"{self.program.file}: {name} is in no team; use a Left... or Right... class")
        if not isinstance(role, str) or role not in ROLES:
            found = "a random role" if isinstance(role, np.ndarray) else f"the role {role!r}"
            raise CastingError(f"{self.program.file}: {name} has {found}; give it one of {', '.join(ROLES)}")
        return TEAMS[team], ROLES[role]

    def _check_teams(self) -> None:
        teams = np.asarray(self.lineup.teams)
        if not (teams == LEFT).any():
            raise CastingError(
                f"{self.program.file}: the learner plays on the left, and this program has no left player"
            )
        for name, team in TEAMS.items():
            count = int((teams == team).sum())
            if count > MAX_PLAYERS // 2:
                raise CastingError(
                    f"{self.program.file}: {count} {name} players; a team has at most {MAX_PLAYERS // 2}"
                )


def _settings(program: Program) -> MatchConfig:
    chosen = {name: value for name, value in program.params.items() if name in SETTINGS}
    for name, value in chosen.items():
        default = getattr(MatchConfig(), name)
        fits = isinstance(value, (int, float)) and (isinstance(value, bool) or not isinstance(default, bool))
        if not fits or (name == "game_duration" and not (float(value).is_integer() and value >= 1)):
            wanted = {bool: "True or False", int: "a whole number of steps, 1 or more", float: "a number"}[
                type(default)
            ]
            raise CastingError(f"{program.file}: param {name} must be {wanted}, not {value!r}")
    return MatchConfig(**chosen)
