"""Play small programs in the toy world: what tests of the dynamic half begin with."""

import numpy as np

from regista.envs.toy_world import toy_world
from scenic_lite import load
from tests.reference.interpreter import Reference
from tests.scenic_lite.dynamics.toy_world import first_table, run


def played(text, steps=6, drift=1.0, dialect=3, seed=0, theta=None, timestep=1.0):
    """Return the reference and the trace of one episode; without theta all draws have their middle value."""
    program = load(text, dialect=dialect)
    theta = np.zeros(program.dim) if theta is None else np.asarray(theta, dtype=float)
    reference = Reference(program, theta, toy_world(timestep), seed)
    return reference, run(first_table(program, theta), reference, steps, drift)


def actions(text, steps=6, **settings):
    """Return what the first object does in each step, as one text: steps separated by blanks, "-" for none."""
    _, trace = played(text, steps, **settings)
    return " ".join(",".join(map(str, each.actions[0])) or "-" for each in trace.commands)
