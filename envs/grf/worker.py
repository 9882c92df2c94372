"""The process that holds Google Research Football: it reads requests from stdin, plays, and answers on stdout.

This file alone runs under the Python that has gfootball, and needs nothing but that, NumPy and the standard library.
Regista imports it for the messages, which both sides must write alike:

    b"RGRF"  size of the header  size of the body     HEAD, 12 bytes
    header                                            JSON; "arrays" lists [name, dtype, shape] of what the body holds
    body                                              the arrays, one after the other

    hello                     -> protocol, versions
    begin slots scenes seeds, lengths [K], actions [sum of lengths, 22]     -> observed [K]
    step slots, actions [K, 22]                                             -> observed [K]

Every request says in how many `seconds` it must be done: the system ends a process that takes longer, even one whose
engine hangs. When whoever asked is gone, the process ends within a second, also where another one still holds a copy of
its stdin. It may name slots to `forget`. `begin` resets each slot's engine to its scene
and plays the actions that it is sent, by which an interrupted episode is repeated. What goes wrong in a request is
answered by an "error".
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
LARGEST = 1 << 28  # bytes of a header or a body; more is no message of ours

GRACE = 2  # s after which a process ends itself that should have been ended by then

TEAM = 11  # rows of a team: left players 0 to 10, right players 11 to 21, whether they are there or not
ROWS = 2 * TEAM
ROLES = ("GK", "CB", "LB", "RB", "DM", "CM", "LM", "RM", "AM", "CF")
LEVEL = "regista_scene"  # of gfootball.scenarios; lives in memory alone
BASE = 20  # several actions of one player are digits of this base, the first highest

# The engine cannot do without a keeper, first in his team: one that has none gets one that nobody is told of, who
# stands still in the corner into which the engine puts that of an empty team.
ABSENT_KEEPER = (-1.0, 0.42, 0, True, False)

# One player, one match, as the engine reports them: its units and its frame, y pointing down, the left team attacking
# +x. Every field has eight bytes, so that equal records are equal bytes. `controller`: the number of the agent of his
# team who has him, or -1; his sticky keys are that agent's.
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
        ("agents", "i8", (ROWS,)),  # rows of the players whom the agents have, left agents first, -1: none
        ("reward", "f8"),
        ("done", "i8"),
        ("players", PLAYER_SEEN, (ROWS,)),
    ]
)


class ProtocolError(Exception):
    """Bytes that are no message."""


# ---------------------------------------------------------------- messages


def pack(message: dict[str, Any], **arrays: np.ndarray) -> bytes:
    """Return a message as bytes."""
    listed = [[name, describe(array.dtype), list(array.shape)] for name, array in arrays.items()]
    header = json.dumps({**message, "arrays": listed}).encode()
    body = b"".join(np.ascontiguousarray(array).tobytes() for array in arrays.values())
    return HEAD.pack(MAGIC, len(header), len(body)) + header + body


def unpack(read: Callable[[int], bytes]) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Read one message; `read(n)` gives exactly n bytes. Raises ProtocolError for what is none."""
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
        raise ProtocolError(f"a message that cannot be read: {error}") from error
    if at != len(body):
        raise ProtocolError(f"a message with {len(body)} bytes of arrays that should have {at}")
    return message, arrays


def describe(dtype: np.dtype) -> str:
    """Return the name of an array's type in a message."""
    return "observed" if dtype == OBSERVED else dtype.str


# ---------------------------------------------------------------- the engine


class Match:
    """One match on an engine of its own, driven through the class on which gfootball's environment rests."""

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
        """Play a step with an action for every row `[22]`; rows that no agent has are not looked at."""
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
        """Write the match as it is into `seen`, OBSERVED `[1]`."""
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
        """Write the players of a team, and who of them the agents from number `first` on have; return what is next."""
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
        """Leave the engine to the next match."""
        self.core.close()


def digits(actions: int) -> list[int]:
    """Return several actions that are digits of one number, the first highest."""
    last_first = [actions % BASE]
    while actions >= BASE:
        actions //= BASE
        last_first.append(actions % BASE)
    return last_first[::-1]


def install(scene: dict[str, Any], hidden: list[int]) -> None:
    """Make a scene the scenario module that gfootball imports next: no file in its folder.

    `hidden` says which teams get an ABSENT_KEEPER.
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
        """Do what a request asks; return the answer."""
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
            raise ProtocolError(f"there is no request {request['do']!r}")
        observed = np.zeros(len(request["slots"]), OBSERVED)
        for at, slot in enumerate(request["slots"]):
            self.matches[slot].observe(observed[at : at + 1])
        return pack({}, observed=observed)

    def begin(self, request: dict[str, Any], arrays: dict[str, np.ndarray]) -> None:
        """Reset the slots to their scenes, and repeat what has been played of them."""
        played = np.split(arrays["actions"], np.cumsum(arrays["lengths"])[:-1])
        for at, slot in enumerate(request["slots"]):
            self.forget(slot)
            match = self.matches[slot] = Match(request["scenes"][at], request["seeds"][at])
            for actions in played[at]:
                match.step(actions)

    def forget(self, slot: int) -> None:
        """End the match of a slot, if there is one."""
        if slot in self.matches:
            self.matches.pop(slot).close()


def engine_version() -> str:
    """Return the version of gfootball, which this imports."""
    from importlib.metadata import version

    import gfootball.env.football_env_core  # noqa: F401 (an engine that cannot be loaded is reported now)

    return version("gfootball")


def read_exactly(stream: Any, count: int) -> bytes:
    """Read so many bytes; at the end of the stream the process is over, for whoever asked is gone."""
    data = stream.read(count)
    if len(data) < count:
        raise SystemExit(0)
    return data


def end_with(parent: int) -> None:
    """End this process as soon as its parent is another one: the one that started it is gone."""
    while os.getppid() == parent:
        time.sleep(1.0)
    os._exit(0)


def main() -> None:
    """Serve until stdin ends. All that gfootball prints goes to stderr: stdout belongs to the answers."""
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
    sys.path.pop(0)  # this file's folder, whose modules are not for gfootball
    main()
