"""The package as a whole, its modules by name: for `from scenic.simulators.gfootball import model`."""

import football.model as model
import football.actions as actions
import football.behaviors as behaviors
import football.constants as constants
import football.simulator as simulator
