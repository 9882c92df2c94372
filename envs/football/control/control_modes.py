"""The control modes: which players of a team agents move, and the assignment at the beginning of a match.

    closest1, closest2, closest3    the players closest to the ball, nearest first, chosen again before every action
    active                          one player, as for a single agent of Google Research Football: on the ball or
                                    much sooner at it, the receiver as soon as a pass leaves the foot. At the start
                                    it is the keeper, or the player of a fixed index; control goes to the ball within
                                    the first step, whose kick or slide is then lost: see `control.active_player`
    a whole number N                the N closest at the start, nearest first; they stay
    all, allNonGK                   all players, or all but the keeper, in the order of the program; they stay
    none                            no players: the built-in AI moves the whole team

Ties are broken by the order of the program. Only `active` begins in the same way as GRF. In all other modes, an action
always moves the player of the preceding observation. Read next: `control.agents`, the assignment in each step.
"""

from __future__ import annotations

import numpy as np

from regista.envs.football.config import check_control
from regista.envs.football.constants import ACTIVE, CLOSEST, FIXED, GK, LEFT, NO_AGENTS, NOBODY, RIGHT
from regista.envs.football.control.active_player import FIRST_PLAYERS

_KINDS = {"none": NO_AGENTS, "active": ACTIVE, "closest1": CLOSEST, "closest2": CLOSEST, "closest3": CLOSEST}


def count_agents(mode: str | int, roles: np.ndarray, team: int = LEFT) -> int:
    """Return the number of agents of a team with these roles `[P]`. Raises ValueError if it has too few players."""
    text, size = check_control(mode), len(roles)
    if text == "allNonGK":
        keepers = int(np.count_nonzero(roles == GK))
        if keepers != 1:
            raise ValueError(f"control 'allNonGK' needs exactly one keeper in {_name(team)}, which has {keepers}")
        size -= 1
    if text in ("all", "allNonGK"):
        agents = max(size, 1)
    elif text in ("none", "active"):
        agents = int(text == "active")
    else:
        agents = int(text.removeprefix("closest"))
    if agents > size:
        raise ValueError(f"control {text!r} needs {agents} players in {_name(team)}, which has {size}")
    return agents


def assign_agents(matches: np.ndarray, modes: tuple[str | int, str | int]) -> None:
    """Assign players to the agents of new matches MATCH `[N]`; `modes` are those of the left and the right team."""
    players = matches["players"][:, : matches["num_players"][0]]
    matches["agents"], matches["players"]["agent"] = NOBODY, NOBODY
    first = 0
    for team, mode in zip((LEFT, RIGHT), modes, strict=True):
        members = np.flatnonzero(players["team"][0] == team)
        members = members[np.argsort(players["order"][0, members], kind="stable")]
        count = count_agents(mode, players["role"][0, members], team)
        matches["num_agents"][:, team] = count
        matches["control"][:, team] = _KINDS.get(str(mode), FIXED)
        if str(mode) == "active":  # GRF counts players by their index
            members = members[np.argsort(players["shirt"][0, members])]
            matches["designated"][:, team] = members[0]
        chosen = _chosen(str(mode), players[:, members], matches["ball"])[:, :count]
        matches["agents"][:, first : first + count] = members[chosen]
        first += count
    rows = np.arange(len(matches))
    for agent in range(first):
        matches["players"]["agent"][rows, matches["agents"][:, agent]] = agent


def _chosen(mode: str, members: np.ndarray, ball: np.ndarray) -> np.ndarray:
    """Return the order of the members `[N, M]` by distance, ties in program order: indices `[N, M]`."""
    if mode == "active":
        size = members.shape[1]
        return np.full((len(members), 1), FIRST_PLAYERS[min(size, len(FIRST_PLAYERS) - 1)])
    if mode == "all":
        return np.broadcast_to(np.arange(members.shape[1]), members.shape)
    if mode == "allNonGK":
        return np.broadcast_to(np.flatnonzero(members["role"][0] != GK), (len(members), members.shape[1] - 1))
    along, across = members["x"] - ball["x"][:, None], members["y"] - ball["y"][:, None]
    return np.argsort(along**2 + across**2, axis=1, kind="stable")


def _name(team: int) -> str:
    return "the left team" if team == LEFT else "the right team"
