"""The record of a football match: all that changes in it, declared once.

Each table below names a field, the numbers that it may hold (see `limits`), its shape, its unit and its meaning; the
NumPy dtypes are made from them. Resetting is `matches[e] = starts[e]`, saving is `np.save`, comparing is `==`. Players
of the left team attack +x; +y is up.

Who has the ball is five questions:

    carrier            who leads it with his feet or holds it now; -1 while it is free
    last_carrier       who carries it or did so last: the built-in AI counts his steps
    keeper_holding     the keeper who has it in his hands; he is the carrier, too
    last_touch         who touched it last, whether it stayed with him or not
    reported_owner     whom observations and programs call its owner, by the original's measure: the last to touch it,
                       as long as it stays near him, low and about as fast as he is

Read next: `kick_off`, which fills a record; `simulator`, which moves a match on by one step.
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

BALL_MEMORY = 41  # steps of the ring in which the ball's places are summed up: averages over 4 s at most

# What fields may hold
REAL, COUNT, TICKS = Real(), Whole(0, 10**9), Whole(-(10**9), 10**9)
WHO, AGENT, SIDE = Whole(NOBODY, "players"), Whole(NOBODY, "agents"), Whole(NOBODY, RIGHT)
NUMBER, CONTROL = Whole(0, "players", given=True), Whole(NO_AGENTS, FIXED, given=True)
BITS = Whole(0, 2**MAX_PLAYERS - 1)  # one for each player
KEYS = Whole(STAND, NUM_COMMANDS**8 - 1)
MODE, END, FAULT = Whole(NORMAL, PENALTY), Whole(RUNNING, REJECTED), Whole(NO_FAULT, PROGRAM_FAULT)

# Moved by `physics.ball` in every frame, set by whatever touches it (`physics.dribble`, `skills`)
BALL_FIELDS: Table = (
    ("x", REAL, (), "m", "place of the centre"),
    ("y", REAL, (), "m", ""),
    ("z", REAL, (), "m", "height of the centre above the ground"),
    ("vx", REAL, (), "m/s", "velocity"),
    ("vy", REAL, (), "m/s", ""),
    ("vz", REAL, (), "m/s", ""),
    ("spin_x", REAL, (), "m/s", "speed of the surface at the bottom, seen from the centre, reversed: v when rolling"),
    ("spin_y", REAL, (), "m/s", ""),
    ("curl", REAL, (), "rad/s", "spin about the vertical: positive bends the flight to the left"),
)

# In what the engine of this episode differs from the measured one: see `physics.variation`, which draws them
ENGINE_FIELDS: Table = (
    ("reaction_time", REAL, (), "", "factor of the time by which built-in players are behind with what they see"),
    ("start_lag", REAL, (), "", "factor of the time that bodies take to answer a new command"),
    ("keeper_speed", REAL, (), "", "factor of keepers' sprints and dives"),
    ("keeper_range", REAL, (), "", "factor of how far keepers leave their goals"),
    ("keeper_reach", REAL, (), "", "factor of how far from them keepers reach a shot"),
    ("tackle_odds", REAL, (), "", "factor of the chance to win the ball off a carrier's feet"),
    ("kick_spread", REAL, (), "", "factor of how far kicks scatter"),
    ("sticky_noise", REAL, (), "", "chance per step that an agent's last action is played once more, not its new one"),
)

PLAYER_FIELDS: Table = (
    # Written once, by `kick_off`
    ("team", Whole(LEFT, RIGHT, given=True), (), "", "0 left, 1 right"),
    ("role", Whole(GK, CF, given=True), (), "", "0 keeper .. 9 forward"),
    ("shirt", NUMBER, (), "", "index within the team, in program order"),
    ("order", NUMBER, (), "", "place among the program's players: who comes first where two are equal"),
    ("start_x", REAL, (), "m", "place at kick-off"),
    ("start_y", REAL, (), "m", ""),
    ("slot_x", REAL, (), "", "slot of his number in the formation: -1 back .. 1 front"),
    ("slot_y", REAL, (), "", "-1 .. 1 across the pitch, as he sees it: to his left"),
    ("top_speed", REAL, (), "m/s", "full sprint without the ball"),
    ("skill", REAL, (), "", "0.3 + 0.7 × difficulty of the team"),
    ("reaction_time", REAL, (), "", "factor, see ENGINE_FIELDS"),
    ("start_lag", REAL, (), "", "factor, the same"),
    # Who moves him, and how: `control` at the beginning and at the end of a step, its keys in between
    ("agent", AGENT, (), "", "agent whose next action moves him, an index into `agents`; -1 none"),
    ("action", KEYS, (), "", "this step's action, 0..18, 19 the built-in AI decides, -1 to stand; or some in base 20"),
    ("direction", Whole(0, DIRECTION_BOTTOM_LEFT), (), "", "sticky: 1..8 as the actions are numbered, 0 none"),
    ("sprint", "?", (), "", "sticky"),
    ("dribble", "?", (), "", "sticky"),
    ("desired_vx", REAL, (), "m/s", "velocity that his keys or the built-in AI ask for in this step"),
    ("desired_vy", REAL, (), "m/s", ""),
    # The kick that his keys or the built-in AI ask for, until `skills.kicks` has carried it out
    ("kick", Whole(0, SHOT), (), "", "0 none, or the action asked for: 9..12"),
    ("kick_held", COUNT, (), "steps", "how long the button has been held"),
    ("kick_ready", "?", (), "", "the button has been released: kick when possible"),
    ("kick_patience", TICKS, (), "steps", "left until a kick that found no ball is forgotten"),
    ("kick_mate", WHO, (), "", "player for whom the pass asked for is meant, -1 nobody"),
    ("kick_wait", REAL, (), "s", "until the foot meets the ball"),
    ("is_aimed", "?", (), "", "the kick goes to (aim_x, aim_y), not where the direction keys say"),
    ("aim_x", REAL, (), "m", "where the kick is meant to go; for a learner, set when it leaves the foot"),
    ("aim_y", REAL, (), "m", ""),
    # His body: `physics.motion` once a step, `frames` in every frame
    ("x", REAL, (), "m", "place"),
    ("y", REAL, (), "m", ""),
    ("vx", REAL, (), "m/s", "velocity"),
    ("vy", REAL, (), "m/s", ""),
    ("facing_x", REAL, (), "", "unit vector, where the body looks"),
    ("facing_y", REAL, (), "", ""),
    ("near_bits", BITS, (), "", "bit j: he could meet player j, who comes before him, within this step"),
    ("turning", COUNT, (), "steps", "since velocity and command differ"),
    (
        "stance_wait",
        REAL,
        (),
        "s",
        "until the body leaves the stance of the first whistle, has stopped with the ball, or ends a touch",
    ),
    ("tiredness", REAL, (), "", "0 fresh .. 0.99"),
    ("stride", REAL, (), "s", "since he last played the ball that he leads; negative until he does, going for it"),
    ("lunge_loss", REAL, (), "m/s", "by which going for that touch holds him back, or negative drives him on"),
    # What a duel leaves behind: `skills.tackles`, `skills.contacts`; the times run down at the end of a step
    ("touch_wait", Real(math.inf), (), "s", "until this player can touch the ball again"),
    ("down_wait", Real(math.inf), (), "s", "until he is on his feet again after a slide or a dive"),
    ("pushed", REAL, (), "m", "by which other bodies have just moved him: his shots are weak then, and go astray"),
    ("brings_down", "?", (), "", "the ball still rolls from the player's first touch, and his run hardly changes"),
    ("turns_wide", "?", (), "", "the player's turn with the ball has begun in a sprint: it goes in an arc"),
    ("is_sliding", "?", (), "", "the player is down because he slides into a tackle"),
    ("is_slide_spent", "?", (), "", "his slide has met the carrier: felled him, or not"),
    # Cards: `rules.fouls`
    ("cards", Whole(0, 2), (), "", "1 cautioned (yellow), 2 sent off (red, or the second yellow)"),
    ("leave_wait", REAL, (), "s", "until a player who has been sent off leaves the pitch"),
    ("has_left", "?", (), "", "has left the pitch: stands far beside it, does nothing and is in nobody's way"),
    # What the built-in AI remembers of him: `ai.formation`, `ai.positions`, `ai.marking`, every few steps
    ("post", Whole(0, "players"), (), "", "player of his team whose slot he has for now"),
    ("slot_place_x", REAL, (), "m", "where the slot of his number is now"),
    ("slot_place_y", REAL, (), "m", ""),
    ("place_x", REAL, (), "m", "where he wants to be without the ball, from one decision to the next"),
    ("place_y", REAL, (), "m", ""),
    ("place_step", COUNT, (), "steps", "the last in which he wanted to be there, not at the ball"),
    ("mean_speed", REAL, (), "m/s", "averaged over the last seconds: who has run for long runs less"),
    ("marked_opponent", WHO, (), "", "opponent whom he marks, -1 none"),
)

MATCH_FIELDS: Table = (
    # Written once, by `kick_off`: who plays
    ("num_players", Whole(1, MAX_PLAYERS, given=True), (), "", "rows of `players` in use"),
    ("control", CONTROL, (2,), "", "how each team's agents get their players: `constants.NO_AGENTS` to `FIXED`"),
    ("num_agents", Whole(0, MAX_PLAYERS // 2, given=True), (2,), "", "of the left and of the right team"),
    ("starter", Whole(LEFT, RIGHT), (), "", "team nearer to the ball at first; the other one starts the second half"),
    ("ball_start_x", REAL, (), "m", "where the ball was at kick-off"),
    ("ball_start_y", REAL, (), "m", ""),
    # Written once, by `kick_off`: settings of the episode
    ("game_duration", Whole(1, 10**9), (), "steps", ""),
    ("end_episode_on_score", "?", (), "", ""),
    ("end_episode_on_out_of_play", "?", (), "", ""),
    ("end_episode_on_possession_change", "?", (), "", ""),
    ("offsides", "?", (), "", ""),
    ("deterministic", "?", (), "", "every episode repeats the same stream of random numbers"),
    ("use_magnet", "?", (), "", "a free ball pulls the best placed player whatever his agent's direction"),
    ("agents_only", "?", (), "", "in a team with agents behaviors move their players, and nobody else"),
    ("second_half", COUNT, (), "steps", "played when the second half begins; beyond the duration there is none"),
    (
        "engine_spread",
        REAL,
        (),
        "",
        "by which the factors of `engine` are drawn anew around what they are, per episode",
    ),
    # Written by every draw
    ("random", "u8", (), "", "state of the stream of random numbers"),
    # Who decides for whom in the next step: `control` at the end of a step
    ("agents", WHO, (MAX_PLAYERS,), "", "player whom each agent's next action moves, left agents first; -1 nobody"),
    (
        "designated",
        WHO,
        (2,),
        "",
        "player of each team who is to win the ball, where an agent is `active`; -1 none yet",
    ),
    ("last_actions", Whole(BY_PROGRAM, BUILTIN_AI), (MAX_PLAYERS,), "", "each agent's, for `engine.sticky_noise`"),
    # Who has the ball: `skills` and `physics.possession`, whenever it is touched, lost or kicked
    ("carrier", WHO, (), "", "player who leads the ball with his feet or holds it, -1 for a free ball"),
    ("keeper_holding", WHO, (), "", "keeper with the ball in his hands, -1 none"),
    ("hold_wait", TICKS, (), "steps", "until he kicks it out"),
    ("kicker", WHO, (), "", "player in the middle of a kick, -1 none"),
    ("last_touch", WHO, (), "", "player, -1 none yet"),
    ("was_kicked", "?", (), "", "the last touch was a kick: of a mate's, keepers must not take it with their hands"),
    ("kick_age", REAL, (), "s", "since the last kick"),
    ("receiver", WHO, (), "", "player for whom the last kick was meant, -1 nobody; he need not have the ball yet"),
    # Who goes for the ball: `physics.possession` in every step, `skills.saves` when a shot leaves the foot
    ("chaser", WHO, (2,), "", "player of each team who can be first at the ball"),
    ("arrival", REAL, (2,), "s", "until he can"),
    ("saver", WHO, (), "", "keeper against whom a shot is under way, -1 none"),
    ("save_x", REAL, (), "m", "where he means to meet it"),
    ("save_y", REAL, (), "m", ""),
    ("save_wait", REAL, (), "s", "until the ball is there"),
    ("save_gap", REAL, (), "m", "from where he was to there, when the shot left the foot"),
    ("save_succeeds", "?", (), "", "drawn when the shot left the foot"),
    # What the built-in AI remembers of the match: `ai.balance`, `ai.marking`, `ai.support`, before anybody decides
    ("ball_sums", REAL, (BALL_MEMORY, 2), "m", "x and y of the ball, summed up since play was stopped; a ring"),
    ("remembered", COUNT, (), "steps", "since then; its rest by the ring's length is the latest entry"),
    ("hold", REAL, (2,), "", "each team's on the ball: 0.5 the others have it, 1.5 this team"),
    ("lean", REAL, (), "", "by which the left team's hold was greater in the last seconds"),
    ("slow_ball", REAL, (2,), "m", "x and y of the ball, averaged over `formation.CLOSE_UP.slow`"),
    ("quick_ball", REAL, (2,), "m", "the same over `CLOSE_UP.quick`"),
    ("trap", REAL, (2,), "m", "how far forward of the middle, as it plays, a team's line is: negative"),
    (
        "second_last",
        Real(math.inf),
        (2,),
        "m",
        "how far back, as it plays, a team's second-last is seen; -inf none",
    ),
    ("team_in_possession", SIDE, (), "", "team that has the ball or will be first at it, -1 none"),
    ("last_carrier", WHO, (), "", "player who has the ball or had it last"),
    ("carry_age", COUNT, (), "steps", "since he got it"),
    ("hunter", WHO, (2, 2), "", "per team, the two players nearest to the opponent on the ball, -1 none"),
    ("helper", WHO, (2,), "", "player of each team who offers himself to the mate on the ball, -1 none"),
    ("runner", WHO, (2,), "", "player of each team on an attacking run, -1 none"),
    ("run_steps_left", TICKS, (2,), "steps", "until that run ends"),
    # What referee's calls are due: `skills` report them within a step, `rules` deal with them at its end
    ("offside_bits", BITS, (), "", "bit i: player i was offside when a mate last kicked"),
    ("foul_player", WHO, (), "", "who committed a foul that has not been dealt with, -1 none"),
    ("foul_victim", WHO, (), "", "who was fouled, -1 none"),
    ("foul_severity", REAL, (), "", "above 1 a foul, above 1.4 yellow, above 2 red"),
    ("foul_x", REAL, (), "m", "where the victim was"),
    ("foul_y", REAL, (), "m", ""),
    ("foul_age", REAL, (), "s", "since then, while play goes on for the victim's advantage"),
    ("is_advantage", "?", (), "", "a trip, for which play goes on; a slide stops it at once"),
    # The state of play: `rules` at the end of a step, `ai.set_pieces` while a restart is due
    ("step", COUNT, (), "steps", "played in this episode"),
    ("half", Whole(0, 1), (), "", "0 the first, 1 the second"),
    ("score", COUNT, (2,), "", "goals of the left and of the right team"),
    ("game_mode", MODE, (), "", "0 normal, 1 kick-off, 2 goal kick, 3 free kick, 4 corner, 5 throw-in, 6 penalty"),
    ("restart_team", SIDE, (), "", "who takes the restart, -1 when none is due"),
    ("restart_wait", COUNT, (), "steps", "since play stopped"),
    ("restart_kick", TICKS, (), "steps", "until the taker meets the ball, -1 while he has not decided"),
    ("taker", WHO, (), "", "player who takes the restart, -1 none"),
    ("line_wait", REAL, (), "s", "after a set piece for which the side lines do not count"),
    ("reported_owner", WHO, (), "", "player in possession as the original reports it, -1 none"),
    ("last_owned_team", SIDE, (), "", "team of the last reported owner, -1 none yet"),
    # What the last step brought: `rules`, then `control.episode` and `control.reward`, then the program's monitors
    ("goal", Whole(-1, 1), (), "", "+1 the left team scored in this step, -1 the right one"),
    ("possession_changed", "?", (), "", "the other team than the last owner's came into possession"),
    ("ended", END, (), "", "0 running, 1 goal, 2 out of play, 3 possession change, 4 duration, 5 program, 6 rejected"),
    ("terminated", "?", (), "", "ended by an event"),
    ("truncated", "?", (), "", "ended by the duration alone, or rejected"),
    ("checkpoint_reward", REAL, (MAX_PLAYERS,), "", "per agent: 0.1 for each checkpoint newly passed in this step"),
    ("checkpoints", Whole(0, 10), (MAX_PLAYERS,), "", "per agent: of the 10, passed in this episode"),
    ("program_reward", "f8", (), "", "what monitors of the program paid for this step"),
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
