"""The record of a football match: all of its state, declared once.

Each row of the tables below gives a field's name, its valid numbers (see `limits`), shape, unit and meaning; the NumPy
dtypes are made from them. Resetting is `matches[e] = starts[e]`, saving is `np.save`, comparing is `==`. Players
of the left team attack +x; +y is up.

Five fields describe who has the ball:

    carrier            the player who leads it with the feet or holds it; -1 while it is free
    last_carrier       the present carrier or the last one: the built-in AI counts that player's steps
    keeper_holding     the keeper who has it in the hands and is also the carrier
    last_touch         the last player to touch it, whether it stayed there or not
    reported_owner     the owner in observations and programs, by GRF's definition: the last player to touch it, as
                       long as it stays near that player, low and about as fast

Read next: `kick_off`, which fills a record; `simulator`, which steps a match.
"""

from __future__ import annotations

import math

import numpy as np

from regista.envs.football.constants import (
    BUILTIN_AI,
    BY_PROGRAM,
    CF,
    DIRECTION_BOTTOM_LEFT,
    FIXED,
    GK,
    LEFT,
    MAX_PLAYERS,
    NO_AGENTS,
    NO_FAULT,
    NOBODY,
    NORMAL,
    NUM_COMMANDS,
    PENALTY,
    PROGRAM_FAULT,
    REJECTED,
    RIGHT,
    RUNNING,
    SHOT,
    STAND,
)
from regista.envs.football.field_kinds import Real, Table, Whole, stored

BALL_MEMORY = 41  # steps of the ring buffer of sums of the ball's positions: averages over 4 s at most

# Kinds of fields
REAL, COUNT, TICKS = Real(), Whole(0, 10**9), Whole(-(10**9), 10**9)
WHO, AGENT, SIDE = Whole(NOBODY, "players"), Whole(NOBODY, "agents"), Whole(NOBODY, RIGHT)
NUMBER, CONTROL = Whole(0, "players", given=True), Whole(NO_AGENTS, FIXED, given=True)
BITS = Whole(0, 2**MAX_PLAYERS - 1)  # one for each player
ACTIONS = Whole(STAND, NUM_COMMANDS**8 - 1)
MODE, END, FAULT = Whole(NORMAL, PENALTY), Whole(RUNNING, REJECTED), Whole(NO_FAULT, PROGRAM_FAULT)

# Updated by `physics.ball` in every frame, set by every touch (`physics.dribble`, `skills`)
BALL_FIELDS: Table = (
    ("x", REAL, (), "m", "position of the center"),
    ("y", REAL, (), "m", ""),
    ("z", REAL, (), "m", "height of the center above the ground"),
    ("vx", REAL, (), "m/s", "velocity"),
    ("vy", REAL, (), "m/s", ""),
    ("vz", REAL, (), "m/s", ""),
    ("spin_x", REAL, (), "m/s", "speed of the surface at the bottom, seen from the center, reversed: v when rolling"),
    ("spin_y", REAL, (), "m/s", ""),
    ("curl", REAL, (), "rad/s", "spin about the vertical: positive bends the flight to the left"),
)

# How the engine of this episode differs from the measured one: drawn by `physics.variation`
ENGINE_FIELDS: Table = (
    ("reaction_time", REAL, (), "", "factor of the reaction time of built-in players"),
    ("start_lag", REAL, (), "", "factor of the time that bodies take to respond to a command"),
    ("keeper_speed", REAL, (), "", "factor of keepers' sprints and dives"),
    ("keeper_range", REAL, (), "", "factor of how far keepers leave their goals"),
    ("keeper_reach", REAL, (), "", "factor of how far from them keepers reach a shot"),
    ("tackle_odds", REAL, (), "", "factor of the chance to win the ball from a carrier"),
    ("kick_spread", REAL, (), "", "factor of how far kicks scatter"),
    (
        "sticky_noise",
        REAL,
        (),
        "",
        "probability per step that an agent's last action is repeated instead of its new one",
    ),
)

PLAYER_FIELDS: Table = (
    # Written once, by `kick_off`
    ("team", Whole(LEFT, RIGHT, given=True), (), "", "0 left, 1 right"),
    ("role", Whole(GK, CF, given=True), (), "", "0 keeper .. 9 forward"),
    ("shirt", NUMBER, (), "", "index within the team, in program order"),
    ("order", NUMBER, (), "", "position among the program's players, which breaks ties"),
    ("start_x", REAL, (), "m", "position at kick-off"),
    ("start_y", REAL, (), "m", ""),
    ("slot_x", REAL, (), "", "formation slot of the shirt number: -1 back .. 1 front"),
    ("slot_y", REAL, (), "", "-1 .. 1 across the pitch, positive to the player's left"),
    ("top_speed", REAL, (), "m/s", "full sprint without the ball"),
    ("skill", REAL, (), "", "0.3 + 0.7 × difficulty of the team"),
    ("reaction_time", REAL, (), "", "factor, see ENGINE_FIELDS"),
    ("start_lag", REAL, (), "", "factor, the same"),
    # Who moves the player, and how: `control` at the beginning and the end of a step, its actions in between
    ("agent", AGENT, (), "", "agent whose next action moves the player, an index into `agents`; -1 none"),
    (
        "action",
        ACTIONS,
        (),
        "",
        "this step's action, 0..18, 19 the built-in AI decides, -1 to stand; or several in base 20",
    ),
    ("direction", Whole(0, DIRECTION_BOTTOM_LEFT), (), "", "sticky: 1..8 as the actions are numbered, 0 none"),
    ("sprint", "?", (), "", "sticky"),
    ("dribble", "?", (), "", "sticky"),
    ("desired_vx", REAL, (), "m/s", "velocity requested by the actions or the built-in AI in this step"),
    ("desired_vy", REAL, (), "m/s", ""),
    # The kick requested by the actions or the built-in AI, until `skills.kicks` has executed it
    ("kick", Whole(0, SHOT), (), "", "0 none, or the requested action: 9..12"),
    ("kick_held", COUNT, (), "steps", "how long the button has been held"),
    ("kick_ready", "?", (), "", "the button has been released: kick when possible"),
    ("kick_patience", TICKS, (), "steps", "left until a kick that found no ball is canceled"),
    ("kick_mate", WHO, (), "", "receiver of the requested pass, -1 nobody"),
    ("kick_wait", REAL, (), "s", "until the foot meets the ball"),
    ("is_aimed", "?", (), "", "the kick goes to (aim_x, aim_y), not in the held direction"),
    ("aim_x", REAL, (), "m", "target of the kick; for an agent, set when it leaves the foot"),
    ("aim_y", REAL, (), "m", ""),
    # The body: `physics.motion` once a step, `frames` in every frame
    ("x", REAL, (), "m", "position"),
    ("y", REAL, (), "m", ""),
    ("vx", REAL, (), "m/s", "velocity"),
    ("vy", REAL, (), "m/s", ""),
    ("facing_x", REAL, (), "", "unit vector of the body's facing"),
    ("facing_y", REAL, (), "", ""),
    ("near_bits", BITS, (), "", "contact mask, bit j: could meet player j, with a lower index, within this step"),
    ("turning", COUNT, (), "steps", "since velocity and command differ"),
    (
        "stance_wait",
        REAL,
        (),
        "s",
        "until the body leaves its stance at the first whistle, has stopped with the ball, or ends a touch",
    ),
    ("tiredness", REAL, (), "", "0 fresh .. 0.99"),
    ("stride", REAL, (), "s", "since the last touch of the led ball; negative during the lunge before a touch"),
    ("lunge_loss", REAL, (), "m/s", "speed lost in the lunge for that touch, or gained if negative"),
    # Effects of duels: `skills.tackles`, `skills.contacts`; the times run down at the end of a step
    ("touch_wait", Real(math.inf), (), "s", "until this player can touch the ball again"),
    ("down_wait", Real(math.inf), (), "s", "until the player is up again after a slide or a dive"),
    ("pushed", REAL, (), "m", "by which other bodies have just moved the player: shots are weak and inaccurate then"),
    ("brings_down", "?", (), "", "the ball still rolls from the player's first touch, and the run hardly changes"),
    ("turns_wide", "?", (), "", "the player's turn with the ball began in a sprint: it goes in an arc"),
    ("is_sliding", "?", (), "", "the player is down in a sliding tackle"),
    ("is_slide_spent", "?", (), "", "the slide has met the carrier and felled the carrier, or not"),
    # Cards: `rules.fouls`
    ("cards", Whole(0, 2), (), "", "1 cautioned (yellow), 2 sent off (red, or the second yellow)"),
    ("leave_wait", REAL, (), "s", "until a player who has been sent off leaves the pitch"),
    ("has_left", "?", (), "", "has left the pitch: is far beside it, idle and out of the way"),
    # The built-in AI's memory: `ai.formation`, `ai.positions`, `ai.marking`, every few steps
    ("post", Whole(0, "players"), (), "", "teammate whose formation slot the player has at present"),
    ("slot_place_x", REAL, (), "m", "present position of the slot of the shirt number"),
    ("slot_place_y", REAL, (), "m", ""),
    ("place_x", REAL, (), "m", "target without the ball, from one decision to the next"),
    ("place_y", REAL, (), "m", ""),
    ("place_step", COUNT, (), "steps", "the last in which that was the target, not the ball"),
    ("mean_speed", REAL, (), "m/s", "averaged over the last seconds: players slow down after long runs"),
    ("marked_opponent", WHO, (), "", "opponent whom the player marks, -1 none"),
)

MATCH_FIELDS: Table = (
    # Written once, by `kick_off`: who plays
    ("num_players", Whole(1, MAX_PLAYERS, given=True), (), "", "rows of `players` in use"),
    ("control", CONTROL, (2,), "", "how each team's agents get their players: `constants.NO_AGENTS` to `FIXED`"),
    ("num_agents", Whole(0, MAX_PLAYERS // 2, given=True), (2,), "", "of the left and of the right team"),
    ("starter", Whole(LEFT, RIGHT), (), "", "team nearer to the ball at first; the other one starts the second half"),
    ("ball_start_x", REAL, (), "m", "ball position at kick-off"),
    ("ball_start_y", REAL, (), "m", ""),
    # Written once, by `kick_off`: settings of the episode
    ("game_duration", Whole(1, 10**9), (), "steps", ""),
    ("end_episode_on_score", "?", (), "", ""),
    ("end_episode_on_out_of_play", "?", (), "", ""),
    ("end_episode_on_possession_change", "?", (), "", ""),
    ("offsides", "?", (), "", ""),
    ("deterministic", "?", (), "", "every episode repeats the same stream of random numbers"),
    ("use_magnet", "?", (), "", "a free ball attracts the best placed player, whatever direction the agent holds"),
    ("agents_only", "?", (), "", "in a team with agents, behaviors move only the agents' players"),
    ("second_half", COUNT, (), "steps", "played when the second half begins; beyond the duration: never"),
    (
        "engine_spread",
        REAL,
        (),
        "",
        "relative spread of the factors of `engine`, drawn per episode around their values",
    ),
    # Written by every draw
    ("random", "u8", (), "", "state of the stream of random numbers"),
    # Which agent moves which player in the next step: `control` at the end of a step
    ("agents", WHO, (MAX_PLAYERS,), "", "player that each agent's next action moves, left agents first; -1 nobody"),
    (
        "designated",
        WHO,
        (2,),
        "",
        "designated player of each team, who should win the ball, for `active` agents; -1 none yet",
    ),
    ("last_actions", Whole(BY_PROGRAM, BUILTIN_AI), (MAX_PLAYERS,), "", "each agent's, for `engine.sticky_noise`"),
    # Who has the ball: `skills` and `physics.possession`, whenever it is touched, lost or kicked
    ("carrier", WHO, (), "", "player who leads the ball with the feet or holds it, -1 for a free ball"),
    ("keeper_holding", WHO, (), "", "keeper with the ball in the hands, -1 none"),
    ("hold_wait", TICKS, (), "steps", "until that keeper kicks it out"),
    ("kicker", WHO, (), "", "player in the middle of a kick, -1 none"),
    ("last_touch", WHO, (), "", "player, -1 none yet"),
    ("was_kicked", "?", (), "", "the last touch was a kick: keepers must not handle a teammate's"),
    ("kick_age", REAL, (), "s", "since the last kick"),
    ("receiver", WHO, (), "", "intended receiver of the last kick, -1 nobody; the ball may still be on its way"),
    # Who goes for the ball: `physics.possession` in every step, `skills.saves` when a shot leaves the foot
    ("chaser", WHO, (2,), "", "player of each team who can be first at the ball"),
    ("arrival", REAL, (2,), "s", "until then"),
    ("saver", WHO, (), "", "keeper against whom a shot is under way, -1 none"),
    ("save_x", REAL, (), "m", "meeting point of keeper and shot"),
    ("save_y", REAL, (), "m", ""),
    ("save_wait", REAL, (), "s", "until the ball is there"),
    ("save_gap", REAL, (), "m", "from the keeper to that point, when the shot left the foot"),
    ("save_succeeds", "?", (), "", "drawn when the shot left the foot"),
    # The built-in AI's memory of the match: `ai.balance`, `ai.marking`, `ai.support`, before all decisions
    ("ball_sums", REAL, (BALL_MEMORY, 2), "m", "sums of the ball's x and y since play was stopped; a ring buffer"),
    ("remembered", COUNT, (), "steps", "since then; modulo the buffer's length it is the latest entry"),
    ("hold", REAL, (2,), "", "share of possession: 0.5 the others have the ball, 1.5 this team"),
    ("lean", REAL, (), "", "possession trend: the left team's share less the right team's, averaged over seconds"),
    ("slow_ball", REAL, (2,), "m", "x and y of the ball, averaged over `formation.CLOSE_UP.slow`"),
    ("quick_ball", REAL, (2,), "m", "the same over `CLOSE_UP.quick`"),
    ("trap", REAL, (2,), "m", "a team's defensive line, forward of the middle in its direction of play: negative"),
    (
        "second_last",
        Real(math.inf),
        (2,),
        "m",
        "a team's second-last player as opponents see it, towards the own goal; -inf none",
    ),
    ("team_in_possession", SIDE, (), "", "team that has the ball or will be first at it, -1 none"),
    ("last_carrier", WHO, (), "", "player who has the ball or had it last"),
    ("carry_age", COUNT, (), "steps", "since that player got it"),
    ("hunter", WHO, (2, 2), "", "pressers: per team, the two players nearest to the opponent on the ball, -1 none"),
    ("helper", WHO, (2,), "", "supporting player of each team, near the teammate on the ball, -1 none"),
    ("runner", WHO, (2,), "", "player of each team on an attacking run, -1 none"),
    ("run_steps_left", TICKS, (2,), "steps", "until that run ends"),
    # Pending referee's calls: reported by `skills` within a step, decided by `rules` at its end
    ("offside_bits", BITS, (), "", "bit i: player i was offside at the last kick of a teammate"),
    ("foul_player", WHO, (), "", "player who committed a pending foul, -1 none"),
    ("foul_victim", WHO, (), "", "player who was fouled, -1 none"),
    ("foul_severity", REAL, (), "", "above 1 a foul, above 1.4 yellow, above 2 red"),
    ("foul_x", REAL, (), "m", "position of the victim"),
    ("foul_y", REAL, (), "m", ""),
    ("foul_age", REAL, (), "s", "since then, while play goes on for the victim's advantage"),
    ("is_advantage", "?", (), "", "a trip with advantage: play goes on; after a slide it stops at once"),
    # The state of play: `rules` at the end of a step, `ai.set_pieces` while a restart is due
    ("step", COUNT, (), "steps", "played in this episode"),
    ("half", Whole(0, 1), (), "", "0 the first, 1 the second"),
    ("score", COUNT, (2,), "", "goals of the left and of the right team"),
    ("game_mode", MODE, (), "", "0 normal, 1 kick-off, 2 goal kick, 3 free kick, 4 corner, 5 throw-in, 6 penalty"),
    ("restart_team", SIDE, (), "", "team that takes the pending restart, -1 none"),
    ("restart_wait", COUNT, (), "steps", "since play stopped"),
    ("restart_kick", TICKS, (), "steps", "until the taker meets the ball, -1 before the decision"),
    ("taker", WHO, (), "", "player who takes the restart, -1 none"),
    ("line_wait", REAL, (), "s", "after a set piece during which the side lines do not count"),
    ("reported_owner", WHO, (), "", "player in possession by GRF's definition, -1 none"),
    ("last_owned_team", SIDE, (), "", "team of the last reported owner, -1 none yet"),
    # Results of the last step: `rules`, then `control.episode` and `control.reward`, then the program's monitors
    ("goal", Whole(-1, 1), (), "", "+1 the left team scored in this step, -1 the right one"),
    ("possession_changed", "?", (), "", "possession changed to the other team than the last owner's"),
    ("ended", END, (), "", "0 running, 1 goal, 2 out of play, 3 possession change, 4 duration, 5 program, 6 rejected"),
    ("terminated", "?", (), "", "ended by an event"),
    ("truncated", "?", (), "", "ended by the duration alone, or rejected"),
    ("checkpoint_reward", REAL, (MAX_PLAYERS,), "", "per agent: 0.1 for each checkpoint newly passed in this step"),
    ("checkpoints", Whole(0, 10), (MAX_PLAYERS,), "", "per agent: of the 10, passed in this episode"),
    ("program_reward", "f8", (), "", "reward of the program's monitors for this step"),
    ("fault", FAULT, (), "", "0 none, 1 a value is not a number, 2 no such action, 3 in the program"),
)

NOBODY_YET = (
    *("reported_owner", "carrier", "keeper_holding", "kicker", "last_touch", "last_owned_team", "saver", "chaser"),
    *("receiver", "restart_team", "restart_kick", "taker", "foul_player", "foul_victim", "designated"),
    *("team_in_possession", "last_carrier", "hunter", "helper", "runner"),
)


def _dtype(table: Table) -> np.dtype:
    return np.dtype([(name, stored(kind), shape) for name, kind, shape, _, _ in table], align=True)


BALL = _dtype(BALL_FIELDS)
ENGINE = _dtype(ENGINE_FIELDS)
PLAYER = _dtype(PLAYER_FIELDS)
MATCH = np.dtype(
    [(name, stored(kind), shape) for name, kind, shape, _, _ in MATCH_FIELDS]
    + [("ball", BALL), ("engine", ENGINE), ("players", PLAYER, (MAX_PLAYERS,))],
    align=True,
)

TABLES: dict[np.dtype, Table] = {BALL: BALL_FIELDS, ENGINE: ENGINE_FIELDS, PLAYER: PLAYER_FIELDS, MATCH: MATCH_FIELDS}
