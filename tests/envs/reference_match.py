"""A football match whose behaviors the reference interpreter plays: what the compiled path must agree with.

Python stands between the kernels: the world table goes to the reference, its commands to the players. Draws come
from the match's own stream, as in the batch.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from regista.envs.football.constants import RUNNING
from regista.envs.football.control.agents import assign_actions
from regista.envs.football.physics.motion import take_stance
from regista.envs.football.scenic.lineup import Lineup
from regista.envs.football.scenic.scripted_step import command_players
from regista.envs.football.scenic.world import FOOTBALL_WORLD
from regista.envs.football.scenic.world_fields import FACTS
from regista.envs.football.scenic.world_table import NUM_FIELDS, write_world
from regista.envs.football.simulator import step_everybody
from scenic_lite import Program
from scenic_lite.core.world import Commands, Verdict
from tests.reference.interpreter import Reference


class Moment(NamedTuple):
    """What a step brought."""

    commands: Commands
    verdict: Verdict
    goal: int
    ended: int


class ReferenceMatch:
    """One episode on one level; `match` is the record."""

    def __init__(self, program: Program, theta: np.ndarray, seed: int) -> None:
        self.lineup = Lineup(program)
        self.matches = self.lineup.starts(theta[None], np.array([seed], np.uint64)).view(np.recarray)
        take_stance(self.matches[0])
        self.reference = Reference(program, theta, FOOTBALL_WORLD)
        self.size = len(self.lineup.object_to_player)

    def tables(self) -> tuple[np.ndarray, np.ndarray]:
        row = np.zeros(self.size * NUM_FIELDS + len(FACTS))
        write_world(self.matches[0], self.lineup.object_to_player, row, 0)
        return row[: self.size * NUM_FIELDS].reshape(self.size, NUM_FIELDS), row[self.size * NUM_FIELDS :]

    def step(self, action: int) -> Moment:
        """Act, play, watch; an episode that its behaviors end is not played on."""
        commands = self._ask(self.reference.act)
        if commands.terminated or commands.rejected:
            return Moment(commands, Verdict(0.0, commands.terminated, commands.rejected), 0, RUNNING)
        numbers = np.array([actions[0] if actions else -1.0 for actions in commands.actions], float)
        match = self.matches[0]
        assign_actions(match, np.array([action]))
        command_players(match, self.lineup.object_to_player, numbers)
        step_everybody(self.matches, self.matches["players"]["action"].astype(np.int64))
        verdict = self._ask(self.reference.watch)
        self.matches["program_reward"][0] = verdict.reward
        return Moment(commands, verdict, int(self.matches["goal"][0]), int(self.matches["ended"][0]))

    def _ask(self, question):
        """Ask the reference about the present world; it draws from the match's stream."""
        rng = self.reference.episode._rng
        rng.random = self.matches["random"][0]
        answer = question(*self.tables())
        self.matches["random"][0] = rng.random
        return answer
