"""The process that runs Google Research Football (GRF): it reads requests from stdin, plays, and answers on stdout.

Only this file runs under the Python that has gfootball. It needs gfootball, NumPy and the standard library. Regista
imports this file, too, for the message format:

    b"RGRF"  size of the header  size of the body     HEAD, 12 bytes
    header                                            JSON; "arrays" lists [name, dtype, shape] of the arrays in the
    body
    body                                              the arrays, one after the other

    hello                     -> protocol, versions
    begin slots scenes seeds, lengths [K], actions [sum of lengths, 22]     -> observed [K]
    step slots, actions [K, 22]                                             -> observed [K]

Every request gives a time limit in `seconds`: the operating system ends a process that takes longer, even if GRF hangs.
This process ends within a second of its parent, even if another process still holds a copy of its stdin. A request may
list slots to `forget`. `begin` resets each slot's engine to its scene and replays the actions it receives, which
restores an interrupted episode. A failed request is answered by an "error".
Read next: `grf.workers`, the other end.
"""

from __future__ import annotations

import json
import math
import os
import signal
import struct
import sys
import threading
import time
import traceback
import types
from collections.abc import Callable
from typing import Any

import numpy as np

PROTOCOL = 1
MAGIC = b"RGRF"
HEAD = struct.Struct("<4sII")
LARGEST = 1 << 28  # bytes of a header or a body; a larger message is invalid

GRACE = 2  # s between a request's time limit and the end of the process

TEAM = 11  # rows of a team: left players 0 to 10, right players 11 to 21, including absent players
ROWS = 2 * TEAM
ROLES = ("GK", "CB", "LB", "RB", "DM", "CM", "LM", "RM", "AM", "CF")
LEVEL = "regista_scene"  # name of the scenario module in gfootball.scenarios; it exists in memory only
BASE = 20  # several actions of one player are digits in this base, the first action is the highest digit

# GRF needs a keeper as the first player of each team. A team without one gets a hidden keeper, who stands still in the
# corner where GRF puts the keeper of an empty team.
ABSENT_KEEPER = (-1.0, 0.42, 0, True, False)

# One player and one match as GRF reports them, in its units and frame: y points down, the left team attacks +x. Every
# field has eight bytes, so that equal records are equal bytes. `controller` is the number of the agent in its team
# that controls the player, or -1; the sticky actions are those of that agent.
PLAYER_SEEN = np.dtype(
    [
        *((name, "f8") for name in ("x", "y", "dx", "dy", "tired")),
        *((name, "i8") for name in ("role", "controller", "direction", "sprint", "dribble", "is_active", "has_card")),
    ]
)
OBSERVED = np.dtype(
    [
        *((name, "f8", (3,)) for name in ("ball", "ball_direction", "ball_rotation")),
        *((name, "i8") for name in ("owned_team", "owned_player", "game_mode", "steps_left")),
        ("score", "i8", (2,)),
        ("designated", "i8", (2,)),
        ("agents", "i8", (ROWS,)),  # rows of the agents' players, left agents first, -1: none
        ("reward", "f8"),
        ("done", "i8"),
        ("players", PLAYER_SEEN, (ROWS,)),
    ]
)


class ProtocolError(Exception):
    """Bytes that are not a valid message."""


# ---------------------------------------------------------------- messages


def pack(message: dict[str, Any], **arrays: np.ndarray) -> bytes:
    """Return a message as bytes."""
    listed = [[name, describe(array.dtype), list(array.shape)] for name, array in arrays.items()]
    header = json.dumps({**message, "arrays": listed}).encode()
    body = b"".join(np.ascontiguousarray(array).tobytes() for array in arrays.values())
    return HEAD.pack(MAGIC, len(header), len(body)) + header + body


def unpack(read: Callable[[int], bytes]) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Read one message; `read(n)` returns exactly n bytes. Raises ProtocolError for an invalid message."""
    magic, size, rest = HEAD.unpack(read(HEAD.size))
    if magic != MAGIC or size > LARGEST or rest > LARGEST:
        raise ProtocolError(f"expected a message, got bytes that begin with {magic!r}")
    header = read(size)
    body = read(rest)
    arrays, at = {}, 0
    try:
        message = json.loads(header)
        for name, kind, shape in message.pop("arrays"):
            dtype = OBSERVED if kind == "observed" else np.dtype(kind)
            count = int(np.prod(shape, dtype=np.int64))
            arrays[name] = np.frombuffer(body, dtype, count, at).reshape(shape).copy()
            at += count * dtype.itemsize
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise ProtocolError(f"cannot decode a message: {error}") from error
    if at != len(body):
        raise ProtocolError(f"a message has {len(body)} bytes of arrays; its header gives {at}")
    return message, arrays


def describe(dtype: np.dtype) -> str:
    """Return the name of an array's type in a message."""
    return "observed" if dtype == OBSERVED else dtype.str


# ---------------------------------------------------------------- the engine


class Match:
    """One match in its own engine, played through the core class of gfootball's environment."""

    def __init__(self, scene: dict[str, Any], seed: int) -> None:
        from gfootball.env import config, football_action_set, football_env_core

        self.hidden = [int(bool(team) and team[0][2] != 0) for team in (scene["left"], scene["right"])]
        install(scene, self.hidden)
        left, right = scene["agents"]
        values = {
            "action_set": "v2",
            "level": LEVEL,
            "players": [f"agent:left_players={left},right_players={right}"] if left + right else [],
            "game_engine_random_seed": seed,
            "reverse_team_processing": bool(seed % 2),
        }
        self.config = config.Config(values)
        self.core = football_env_core.FootballEnvCore(self.config)
        self.actions = football_action_set.get_action_set(self.config)
        self.reward, self.done = 0.0, False

    def step(self, actions: np.ndarray) -> None:
        """Play a step with an action for every row `[22]`; actions of rows without an agent are ignored."""
        observed, first = self.core._observation, []
        for team, side in enumerate(("left", "right")):
            for agent, player in enumerate(observed[f"{side}_agent_controlled_player"]):
                row = player - self.hidden[team]
                several = digits(int(actions[TEAM * team + row])) if row >= 0 else [0]
                for action in reversed(several[1:]):
                    self.core._env.perform_action(self.actions[action]._backend_action, team == 0, agent)
                first.append(several[0])
        _, self.reward, self.done, _ = self.core.step(first)

    def observe(self, seen: np.ndarray) -> None:
        """Write the current state into `seen`, OBSERVED `[1]`."""
        observed = self.core._observation
        for name in ("ball", "ball_direction", "ball_rotation", "game_mode", "steps_left", "score"):
            seen[name] = observed[name]
        owner = observed["ball_owned_team"], observed["ball_owned_player"]
        if owner[0] >= 0 and owner[1] < self.hidden[owner[0]]:
            owner = -1, -1
        seen["owned_team"], seen["owned_player"] = owner[0], owner[1] - (self.hidden[owner[0]] if owner[0] >= 0 else 0)
        seen["reward"], seen["done"] = self.reward, self.done
        seen["agents"], seen["players"]["controller"], first = -1, -1, 0
        for team, side in enumerate(("left", "right")):
            seen["designated"][:, team] = observed[f"{side}_team_designated_player"] - self.hidden[team]
            first = self.observe_team(seen, observed, team, side, first)

    def observe_team(self, seen: np.ndarray, observed: dict[str, Any], team: int, side: str, first: int) -> int:
        """Write a team's players and its agents, numbered from `first`; return the next team's first agent."""
        hidden = self.hidden[team]
        players = seen["players"][0, TEAM * team : TEAM * team + len(observed[f"{side}_team"]) - hidden]
        players["x"], players["y"] = observed[f"{side}_team"][hidden:].T
        players["dx"], players["dy"] = observed[f"{side}_team_direction"][hidden:].T
        for name, theirs in (
            *(("tired", "tired_factor"), ("role", "roles")),
            *(("is_active", "active"), ("has_card", "yellow_card")),
        ):
            players[name] = observed[f"{side}_team_{theirs}"][hidden:]
        chosen = observed[f"{side}_agent_controlled_player"]
        for agent, player in enumerate(chosen):
            if player < hidden:
                continue
            sticky = observed[f"{side}_agent_sticky_actions"][agent]
            directions = np.flatnonzero(sticky[:8])
            row = players[player - hidden]
            row["controller"], row["direction"] = agent, directions[0] + 1 if len(directions) else 0
            row["sprint"], row["dribble"] = sticky[8], sticky[9]
            seen["agents"][:, first + agent] = TEAM * team + player - hidden
        return first + len(chosen)

    def close(self) -> None:
        """Close the engine, so that another match can use it."""
        self.core.close()


def digits(actions: int) -> list[int]:
    """Return the actions whose digits form one number, the highest digit first."""
    last_first = [actions % BASE]
    while actions >= BASE:
        actions //= BASE
        last_first.append(actions % BASE)
    return last_first[::-1]


def install(scene: dict[str, Any], hidden: list[int]) -> None:
    """Install a scene as the scenario module that gfootball imports next, without a file in its folder.

    `hidden` flags the teams that get an ABSENT_KEEPER.
    """
    import gfootball_engine as engine

    def build_scenario(builder: Any) -> None:
        for name, value in scene["settings"].items():
            setattr(builder.config(), name, value)
        builder.SetBallPosition(*scene["ball"])
        for team, side in enumerate(("left", "right")):
            builder.SetTeam((engine.e_Team.e_Left, engine.e_Team.e_Right)[team])
            for x, y, role, lazy, controllable in [ABSENT_KEEPER] * hidden[team] + scene[side]:
                place = getattr(engine.e_PlayerRole, "e_PlayerRole_" + ROLES[role])
                builder.AddPlayer(x, y, place, lazy, controllable)

    module = types.ModuleType("gfootball.scenarios." + LEVEL)
    module.build_scenario = build_scenario  # type: ignore[attr-defined]
    sys.modules[module.__name__] = module


# ---------------------------------------------------------------- requests


class Server:
    """The matches of this process, by slot."""

    def __init__(self) -> None:
        self.matches: dict[int, Match] = {}

    def answer(self, request: dict[str, Any], arrays: dict[str, np.ndarray]) -> bytes:
        """Execute a request; return the answer."""
        for slot in request.get("forget", ()):
            self.forget(slot)
        if request["do"] == "hello":
            return pack({"protocol": PROTOCOL, "python": sys.version.split()[0], "gfootball": engine_version()})
        if request["do"] == "begin":
            self.begin(request, arrays)
        elif request["do"] == "step":
            for at, slot in enumerate(request["slots"]):
                self.matches[slot].step(arrays["actions"][at])
        else:
            raise ProtocolError(f"unknown request {request['do']!r}; expected hello, begin or step")
        observed = np.zeros(len(request["slots"]), OBSERVED)
        for at, slot in enumerate(request["slots"]):
            self.matches[slot].observe(observed[at : at + 1])
        return pack({}, observed=observed)

    def begin(self, request: dict[str, Any], arrays: dict[str, np.ndarray]) -> None:
        """Reset the slots to their scenes, and replay the given actions."""
        played = np.split(arrays["actions"], np.cumsum(arrays["lengths"])[:-1])
        for at, slot in enumerate(request["slots"]):
            self.forget(slot)
            match = self.matches[slot] = Match(request["scenes"][at], request["seeds"][at])
            for actions in played[at]:
                match.step(actions)

    def forget(self, slot: int) -> None:
        """End the match in a slot, if there is one."""
        if slot in self.matches:
            self.matches.pop(slot).close()


def engine_version() -> str:
    """Import gfootball and return its version."""
    from importlib.metadata import version

    import gfootball.env.football_env_core  # noqa: F401 (fails here if the engine cannot be loaded)

    return version("gfootball")


def read_exactly(stream: Any, count: int) -> bytes:
    """Read `count` bytes; exit at the end of the stream, since the parent process has ended."""
    data = stream.read(count)
    if len(data) < count:
        raise SystemExit(0)
    return data


def end_with(parent: int) -> None:
    """Exit as soon as the parent process has ended."""
    while os.getppid() == parent:
        time.sleep(1.0)
    os._exit(0)


def main() -> None:
    """Serve until stdin ends. Everything that gfootball prints goes to stderr: stdout is reserved for answers."""
    threading.Thread(target=end_with, args=(os.getppid(),), daemon=True).start()
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    requests, server = sys.stdin.buffer, Server()
    while True:
        request, arrays = unpack(lambda count: read_exactly(requests, count))
        signal.alarm(math.ceil(request["seconds"]) + GRACE)
        try:
            reply = server.answer(request, arrays)
        except Exception:
            reply = pack({"error": traceback.format_exc(limit=-3)})
        signal.alarm(0)
        answers.write(reply)
        answers.flush()


if __name__ == "__main__":
    sys.path.pop(0)  # this file's folder, whose modules gfootball must not import
    main()
