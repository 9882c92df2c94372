"""Google Research Football (GRF) as the engine of a batch: we run the program and the agents, GRF plays the match.

    begin_row     behaviors and agents choose the players' actions                                  in our kernels
    Workers       Google Research Football plays them                                               in its processes
    finish_row    GRF's observations become our record; endings, rewards, monitors, observations    in our kernels

A team that only the built-in AI moves needs no agent in GRF. A team with one `active` agent needs one, if no behavior
moves its players. Any other team needs one agent for each player. A player without a command then takes action 19,
which returns it to the AI, and the AI also kicks for that player. In a team with one agent, the AI leaves the ball to
that agent.
Read next: `grf.workers`.
"""

from __future__ import annotations

import os
import warnings
import weakref
from typing import Any

import numpy as np

from regista.envs.football.batch import Batch, BatchSettings, Outcome, begin
from regista.envs.football.config import FootballConfig
from regista.envs.football.constants import ACTIVE, GK, LEFT, MAX_PLAYERS, NO_AGENTS, RIGHT
from regista.envs.football.kick_off import MatchConfig
from regista.envs.football.limits import StateError
from regista.envs.football.observation.observe import View
from regista.envs.football.observation.units import UNIT_X, UNIT_Y
from regista.envs.football.scenic.compiled_behaviors import CompiledBehaviors
from regista.envs.football.scenic.domain import FACTORS
from regista.envs.football.scenic.lineup import Lineup, NotAMatchError, refusal
from regista.envs.football.state import MATCH
from regista.envs.grf.observed_batch import begin_rows, finish_rows, read_starts, read_steps, write_seeds
from regista.envs.grf.worker import ROWS, TEAM
from regista.envs.grf.workers import Episode, Workers, grf_python, shared_workers

# Meters per scenario unit for players, whose positions GRF stretches a little; the ball uses the units of observations.
PLAYER_X, PLAYER_Y = 55.0, -36.0 * 2.36
SETTINGS = (
    *("game_duration", "second_half", "deterministic", "offsides", "use_magnet"),
    *("left_team_difficulty", "right_team_difficulty"),
    *("end_episode_on_score", "end_episode_on_out_of_play", "end_episode_on_possession_change"),
)


EPISODES = ("grf_matches", "grf_seeds", "grf_checks", "grf_lengths", "grf_actions")  # of a state, besides the batch


class GrfEngine:
    """N matches in Google Research Football. Raises GrfError if it is not installed."""

    def __init__(self, lineup: Lineup, behaviors: CompiledBehaviors, config: FootballConfig, count: int) -> None:
        self.lineup = lineup
        self._code = behaviors.code
        teams = np.asarray(lineup.roster.teams)
        shirts = np.concatenate([np.arange(np.count_nonzero(teams == team)) for team in (LEFT, RIGHT)])
        self._rows = TEAM * teams + shirts
        self._sizes = [int(np.count_nonzero(teams == team)) for team in (LEFT, RIGHT)]
        check_keepers(lineup)
        check_settings(lineup)
        warn_of_factors(lineup)
        self._commanded = commanded_teams(lineup, behaviors)
        self._controllers = np.zeros((count, 2), np.int64)  # number of GRF agents per team, for each match
        python = grf_python(config.grf_python)
        self._workers = shared_workers(python, config.grf_workers or len(os.sched_getaffinity(0)))
        self._played: dict[int, Episode] = {}  # the episodes in GRF, by match
        self._workers.enter()
        self.close = weakref.finalize(self, _let_go, self._workers, self._played)

    def begin(self, batch: Batch, where: np.ndarray, luck: np.ndarray, settings: BatchSettings) -> None:
        """Reset the matches `where` to their initial states."""
        begin(batch, where, luck, settings)
        self._kick_off(batch, where, settings)

    def step(self, batch: Batch, actions: np.ndarray, outcome: Outcome, seen: View, settings: BatchSettings) -> None:
        """Step all matches."""
        playing = np.zeros(len(batch.matches), np.bool_)
        begin_rows(batch, actions, settings, self._code, playing)
        where = np.flatnonzero(playing)
        orders = np.zeros((len(where), ROWS), np.int64)
        orders[:, self._rows] = batch.matches["players"]["action"][where, : len(self._rows)]
        observed = self._workers.play([self._played[int(index)] for index in where], orders)
        read_steps(batch, where, observed, self._controllers, settings, self._code)
        finish_rows(batch, outcome, seen, settings)

    def get_state(self) -> dict[str, np.ndarray]:
        """Return the episodes with their actions so far; the initial states are in `batch.starts`."""
        matches = sorted(self._played)
        episodes = [self._played[index] for index in matches]
        actions = [row for episode in episodes for row in episode.actions]
        return {
            "grf_matches": np.array(matches, np.int64),
            "grf_seeds": np.array([episode.seed for episode in episodes], np.int64),
            "grf_checks": np.array([episode.check for episode in episodes], np.int64),
            "grf_lengths": np.array([len(episode.actions) for episode in episodes], np.int64),
            "grf_actions": np.array(actions, np.int64).reshape(len(actions), ROWS),
        }

    def check_state(self, state: dict[str, Any], count: int) -> None:
        """Raise StateError for a state of our simulator, and for episodes that do not fit `count` matches."""
        if "grf_matches" not in state:
            raise StateError("this state was saved by our simulator, not by Google Research Football")
        arrays = {name: np.asarray(state.get(name)) for name in EPISODES}
        matches, actions = arrays["grf_matches"], arrays["grf_actions"]
        for name, array in arrays.items():
            shape = (*actions.shape[:1], ROWS) if array is actions else (len(np.atleast_1d(matches)),)
            if array.dtype.kind not in "iu" or array.shape != shape or array.min(initial=0) < 0:
                got = f"got {state.get(name)!r:.100}"
                raise StateError(f"{name} of a state must be {list(shape)} integers from 0, {got}")
        if len(set(matches.tolist())) < len(matches) or matches.max(initial=0) >= count:
            raise StateError(f"grf_matches of a state must be different numbers below {count}, got {matches!r:.100}")
        if arrays["grf_lengths"].sum() != len(actions):
            raise StateError(
                f"grf_lengths of a state give {arrays['grf_lengths'].sum()} steps, and grf_actions has {len(actions)}"
            )

    def set_state(self, state: dict[str, Any], batch: Batch) -> None:
        """Restore episodes; each is replayed when next stepped."""
        self._forget(range(len(batch.matches)))
        lengths = np.asarray(state["grf_lengths"])
        parts = np.split(np.asarray(state["grf_actions"]), np.cumsum(lengths)[:-1]) if len(lengths) else []
        rows = zip(state["grf_matches"], state["grf_seeds"], state["grf_checks"], parts, strict=True)
        for index, seed, check, actions in rows:
            scene = self._scene(batch.starts[index], int(index))
            self._played[int(index)] = Episode(scene, int(seed), list(actions), int(check))

    def _kick_off(self, batch: Batch, where: np.ndarray, settings: BatchSettings) -> None:
        """Begin GRF episodes for the matches `where`, which are in their initial states."""
        self._forget(where)
        episodes = []
        for index, seed in zip(where, draw_seeds(batch.matches, where), strict=True):
            scene = self._scene(batch.starts[index], index)
            self._played[int(index)] = episode = Episode(scene, int(seed))
            episodes.append(episode)
        read_starts(batch, where, self._workers.begin(episodes), self._controllers, settings)

    def _forget(self, where: Any) -> None:
        gone = [self._played.pop(int(index)) for index in where if int(index) in self._played]
        self._workers.forget(gone)

    def _scene(self, start: np.ndarray, index: int) -> dict[str, Any]:
        """Return the settings for the worker to set up match number `index` from its initial record MATCH."""
        agents = [self._agents_of(team, int(start["control"][team])) for team in (LEFT, RIGHT)]
        self._controllers[index] = agents
        ball = [float(start["ball"]["x"]) / UNIT_X, float(start["ball"]["y"]) / UNIT_Y]
        teams: list[list[Any]] = [[], []]
        for player in start["players"][: len(self._rows)]:
            side = 1.0 if player["team"] == LEFT else -1.0  # a scenario gives the right team in that team's own frame
            place = [side * float(player["x"]) / PLAYER_X, side * float(player["y"]) / PLAYER_Y]
            teams[player["team"]].append([*place, int(player["role"]), False, True])
        settings = scenario_settings(self.lineup, start)
        return {"settings": settings, "ball": ball, "left": teams[0], "right": teams[1], "agents": agents}

    def _agents_of(self, team: int, control: int) -> int:
        """Return how many GRF agents a team needs under one of our control modes."""
        if self._commanded[team] or control not in (NO_AGENTS, ACTIVE):
            return self._sizes[team]
        return int(control == ACTIVE)


def scenario_settings(lineup: Lineup, start: np.ndarray) -> dict[str, Any]:
    """Return the scenario settings of an episode that begins as this record MATCH.

    GRF plays one step more than its duration (it loses the first action); our simulator plays exactly the duration.
    """
    settings = {name: np.asarray(getattr(lineup.config, name)).item() for name in SETTINGS}
    for name in set(SETTINGS).intersection(lineup.random_settings):
        settings[name] = start[name].item() if name in MATCH.names else difficulty_of(name, start)  # type: ignore
    return settings | {
        "second_half": int(settings["second_half"]),
        "game_duration": int(settings["game_duration"]) - 1,
    }


def difficulty_of(name: str, start: np.ndarray) -> float:
    """Return the difficulty of the left or right team, computed from the skill of its players."""
    players = start["players"][: int(start["num_players"])]
    skills = players["skill"][players["team"] == (LEFT if name.startswith("left") else RIGHT)]
    return round((float(skills[0]) - 0.3) / 0.7, 12) if len(skills) else float(getattr(MatchConfig(), name))


def commanded_teams(lineup: Lineup, behaviors: CompiledBehaviors) -> list[bool]:
    """Return for each team whether behaviors may command its players; `agents_only` excludes teams with agents."""
    compiled = behaviors.compiled
    objects = {number for number in compiled.threads if number >= 0} | {number for number, _, _ in compiled.overridden}
    players = {int(lineup.object_to_player[number]) for number in objects}
    teams = {int(np.asarray(lineup.roster.teams)[player]) for player in players if player >= 0}
    if lineup.config.agents_only:
        teams -= {team for team in teams if lineup.num_agents[team] > 0}
    return [team in teams for team in (LEFT, RIGHT)]


def check_settings(lineup: Lineup) -> None:
    """Raise NotAMatchError for a random setting that decides which players need a GRF agent."""
    if "agents_only" in lineup.random_settings:
        message = "param agents_only must be fixed for Google Research Football, not a random value"
        raise refusal(lineup.program, message, lineup.program.param_places["agents_only"])


def warn_of_factors(lineup: Lineup) -> None:
    """Warn of engine-variation parameters without effect in GRF: all but `sticky_noise`, which repeats actions."""
    for name in sorted((FACTORS | {"engine_spread"}) - {"sticky_noise"}):
        if name in lineup.program.param_places:
            warnings.warn(f"param {name} of {lineup.program.file} has no effect in GRF", stacklevel=2)


def check_keepers(lineup: Lineup) -> None:
    """Raise NotAMatchError for a full team without a keeper: GRF needs one."""
    teams, roles = np.asarray(lineup.roster.teams), np.asarray(lineup.roster.roles)
    for team, name in ((LEFT, "left"), (RIGHT, "right")):
        if np.count_nonzero(teams == team) == MAX_PLAYERS // 2 and not (roles[teams == team] == GK).any():
            raise NotAMatchError(
                f"{lineup.program.file}: the {name} team has {MAX_PLAYERS // 2} players and no keeper; Google Research "
                "Football needs one: leave out a player, or make one of them the keeper"
            )


def _let_go(workers: Workers, played: dict[int, Episode]) -> None:
    """Report to the workers that an environment has been closed."""
    workers.forget(list(played.values()))
    played.clear()
    workers.leave()


def draw_seeds(matches: np.ndarray, where: np.ndarray) -> np.ndarray:
    """Draw a seed for GRF from each match's random stream: `[k]` int64."""
    seeds = np.zeros(len(where), np.int64)
    write_seeds(matches, where, seeds)
    return seeds
