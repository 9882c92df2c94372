"""The units of Google Research Football's observations: x = ±1 near the goal lines, y pointing down.

Read next: `observation.raw`.
"""

from regista.envs.football.constants import METRES_PER_X, METRES_PER_Y

UNIT_X, UNIT_Y = 100 * METRES_PER_X, -100 * METRES_PER_Y  # m per unit
SPIN_UNIT = 1e-4  # of `ball_rotation`: rad/s into tenths of rad/ms

# Large values, which scale observations
RUNNING = 8.0  # m/s, of players
FLYING = 20.0  # m/s, of the ball
ALOFT = 2.5  # m, height: the crossbar
