"""The numbers of the game: pitch, ball, bodies, actions and modes, in meters and seconds.

Values are Google Research Football's own, or fitted to measurements of it. Numbers that only one module needs are at
the top of that module. Read next: `state`.
"""

from __future__ import annotations

# Time
STEP = 0.1  # s, the time of one decision
FRAMES = 10  # physics frames in a step
DT = STEP / FRAMES  # s, one physics frame

# Scenic coordinates: x in [-100, 100], y in [-42, 42]
METRES_PER_X = 0.544
METRES_PER_Y = 0.836

# Pitch
HALF_LENGTH = 55.0  # m, from the halfway line to the goal line
HALF_WIDTH = 36.0  # m, from the middle to the side line
OUT_MARGIN = 0.17  # m, how far the ball's center must be beyond a line to be out or in goal
GOAL_HALF_WIDTH = 3.7  # m
GOAL_HEIGHT = 2.5  # m
BOX_DEPTH = 16.4  # m, the penalty box: from the goal line
BOX_HALF_WIDTH = 20.0  # m
APRON = 3.0  # m, players may stand this far beyond the lines

# Bodies
MAX_PLAYERS = 22
BODY_RADIUS = 0.36  # m
BALL_RADIUS = 0.11  # m
POST_RADIUS = 0.07  # m

# Speeds, m/s
DRIBBLE_SPEED = 3.5
RUN_SPEED = 5.0
TOP_SPEEDS = (7.75, 7.83, 7.75, 7.78, 7.78, 7.94, 7.77, 7.84, 7.99, 8.0, 8.0)  # by index within the team

# Teams
LEFT = 0
RIGHT = 1
NOBODY = -1  # no player, no team

# Roles
GK, CB, LB, RB, DM, CM, LM, RM, AM, CF = range(10)

# Actions
IDLE = 0
DIRECTION_LEFT, DIRECTION_TOP_LEFT, DIRECTION_TOP, DIRECTION_TOP_RIGHT = 1, 2, 3, 4
DIRECTION_RIGHT, DIRECTION_BOTTOM_RIGHT, DIRECTION_BOTTOM, DIRECTION_BOTTOM_LEFT = 5, 6, 7, 8
LONG_PASS, HIGH_PASS, SHORT_PASS, SHOT = 9, 10, 11, 12
SPRINT, RELEASE_DIRECTION, RELEASE_SPRINT, SLIDING, DRIBBLE, RELEASE_DRIBBLE = 13, 14, 15, 16, 17, 18
BUILTIN_AI = 19  # never an agent's action
STAND = -1  # a lazy player, who does nothing; never an agent's action either
NUM_ACTIONS = 19
NO_ACTION = -1  # for steps that none of the 19 actions describes
BY_PROGRAM = -2  # leaves the agent's player to the program; never an agent's own action
NUM_COMMANDS = 20  # including BUILTIN_AI; several actions at once are digits in this base
ACTION_NAMES = (
    *("idle", "left", "top_left", "top", "top_right", "right", "bottom_right", "bottom", "bottom_left"),
    *("long_pass", "high_pass", "short_pass", "shot"),
    *("sprint", "release_direction", "release_sprint", "sliding", "dribble", "release_dribble"),
)

_DIAGONAL = 0.7071067811865476
# Unit vector of each direction action; entry 0 is "no direction".
DIRECTION_X = (0.0, -1.0, -_DIAGONAL, 0.0, _DIAGONAL, 1.0, _DIAGONAL, 0.0, -_DIAGONAL)
DIRECTION_Y = (0.0, 0.0, _DIAGONAL, 1.0, _DIAGONAL, 0.0, -_DIAGONAL, -1.0, -_DIAGONAL)

# The control mode of a team: see `control_modes`
NO_AGENTS, CLOSEST, ACTIVE, FIXED = range(4)
CONTROL_MODES = ("closest1", "closest2", "closest3", "active", "all", "allNonGK", "none")  # or a number

# Modes of the game
NORMAL, KICK_OFF, GOAL_KICK, FREE_KICK, CORNER, THROW_IN, PENALTY = range(7)

# The reason why an episode ended; the last two are the program's `terminate` and a violated requirement of the program
RUNNING, GOAL, OUT_OF_PLAY, POSSESSION, DURATION, TERMINATED, REJECTED = range(7)

# Faults found by a kernel; `scenic_lite.dynamics` describes a fault of the program
NO_FAULT, NOT_A_NUMBER, BAD_ACTION, PROGRAM_FAULT = range(4)
KICK_PATIENCE = 20  # steps for which a requested kick waits for the ball to come into reach
