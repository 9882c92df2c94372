"""Hand-made positions for the simulator's tests, in meters."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from regista.envs.football.constants import CM, FIXED, FREE_KICK, GK, LEFT, NOBODY, RIGHT
from regista.envs.football.kick_off import MatchConfig, Roster, kick_off
from regista.envs.football.simulator import step_matches
from regista.envs.football.state import MATCH

Player = tuple[float, float, int, int]  # x, y, team, role
OPEN = MatchConfig(end_episode_on_score=False, end_episode_on_out_of_play=False, end_episode_on_possession_change=False)


def position(
    players: Sequence[Player], ball: tuple[float, float], config: MatchConfig = OPEN, seeds: Iterable[int] = (0,)
) -> np.ndarray:
    """Return matches MATCH [len(seeds)], all with these players and this ball."""
    seeds = list(seeds)
    places = np.array([[player[:2] for player in players]] * len(seeds), float)
    roster = Roster([player[2] for player in players], [player[3] for player in players])
    return kick_off(places, np.array([ball] * len(seeds), float), roster, seeds, config).view(np.recarray)


def runner(config: MatchConfig = OPEN) -> np.ndarray:
    """Return one left player at (-40, 0) while the ball is dead, which therefore does not pull him."""
    matches = position([(-40.0, 0.0, LEFT, CM), (54.0, 30.0, RIGHT, GK)], (30.0, 30.0), config)
    matches["game_mode"], matches["restart_team"], matches["restart_wait"] = FREE_KICK, LEFT, 10**6
    return matches


def dribbler(config: MatchConfig = OPEN) -> np.ndarray:
    """Return one left player at (-40, 0) with the ball at his feet."""
    matches = position([(-40.0, 0.0, LEFT, CM), (54.0, 30.0, RIGHT, GK)], (-39.6, 0.0), config)
    return play(matches, [0] * 3)


def duel(
    striker: tuple[float, float], keeper: tuple[float, float], seeds: Iterable[int] = (0,), **config: bool
) -> np.ndarray:
    """Return a striker, the ball 1.76 m to his north, the right keeper, and his own keeper far away."""
    players = [(*striker, LEFT, CM), (*keeper, RIGHT, GK), (-53.9, 0.0, LEFT, GK)]
    return position(players, (striker[0], striker[1] + 1.76), MatchConfig(**config), seeds)


def play(matches: np.ndarray, actions: Iterable[int], player: int | None = None) -> np.ndarray:
    """Play the actions one per step, the same in every match, by the given or the controlled player."""
    for action in actions:
        if player is not None:
            take_over(matches, player)
        step_matches(matches, np.full((len(matches), 1), action))
    return matches


def take_over(matches: np.ndarray, player: int) -> None:
    """Let one agent move the same player throughout; NOBODY: the built-in players have the match to themselves."""
    matches["control"], matches["agents"], matches["players"]["agent"] = FIXED, NOBODY, NOBODY
    matches["num_agents"] = 0
    if player != NOBODY:
        team = int(matches["players"]["team"][0, player])
        matches["num_agents"][:, team], matches["agents"][:, 0], matches["players"]["agent"][:, player] = 1, player, 0


def speeds(matches: np.ndarray, actions: Iterable[int], player: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Mean velocity (vx [T], vy [T]) in m/s of a player over each step in which the actions are played."""
    places = [_place(matches, player)]
    for action in actions:
        play(matches, [action], player)
        places.append(_place(matches, player))
    velocity = np.diff(np.array(places), axis=0) / 0.1
    return velocity[:, 0], velocity[:, 1]


def _place(matches: np.ndarray, player: int) -> tuple[float, float]:
    return matches["players"]["x"][0, player], matches["players"]["y"][0, player]


def plain(matches: np.ndarray) -> np.ndarray:
    """Return the same records as an ordinary structured array."""
    return np.asarray(matches).view(MATCH)


def same(first: np.ndarray, second: np.ndarray) -> bool:
    """Return whether two batches are equal field by field, bit for bit (the padding between fields is anything)."""
    return bool((plain(first) == plain(second)).all())
