"""The machine that runs compiled behaviors: one loop over rows, for one thread of one match until it lets time pass.

Nothing is allocated and nothing is decoded; the chain of tests becomes one jump table. The machine knows no football:
the match shows itself in registers and takes one command for each object. Read next: `dynamics.machine.compiled`,
which drives it from Python.
"""

from __future__ import annotations

import math

import numpy as np

from scenic_lite.dynamics.machine.bytecode import (
    COMPLETE,
    FAULT,
    FAULT_ROW,
    MOST_ROWS,
    NO_COMMAND,
    PATIENCE,
    REJECTED,
    REWARD,
    SEEN,
    TERMINATED,
    Fault,
    Op,
)
from scenic_lite.dynamics.machine.vm_geometry import (
    cut,
    in_rectangle,
    in_rings,
    in_sector,
    power,
    quantile,
    rectangles_meet,
    sector_meets,
    sort_order,
)
from scenic_lite.kernels.jit import kernel
from scenic_lite.kernels.rng import uniform

TURN = 2 * math.pi
ENDLESS, ZERO, DOMAIN, INDEX, OWN = map(int, (Fault.ENDLESS, Fault.ZERO, Fault.DOMAIN, Fault.INDEX, Fault.OWN))
# Numba reads plain integers faster than members of an enumeration, and compiles them to constants.
(
    _END,
    _TAKE,
    _WAIT,
    _JUMP,
    _JUMP_IF,
    _JUMP_UNLESS,
    _JUMP_LESS,
    _JUMP_NOT_LESS,
    _JUMP_LESS_EQUAL,
    _JUMP_NOT_LESS_EQUAL,
    _JUMP_EQUAL,
    _JUMP_NOT_EQUAL,
    _SET_SLOT,
    _RESUME,
    _RESUME_IF_RUNNING,
    _COPY,
    _PICK,
    _FETCH,
    _STORE,
    _ADD,
    _SUBTRACT,
    _MULTIPLY,
    _DIVIDE,
    _FLOOR_DIVIDE,
    _MODULO,
    _POWER,
    _NEGATE,
    _ABSOLUTE,
    _MINIMUM,
    _MAXIMUM,
    _LESS,
    _LESS_EQUAL,
    _EQUAL,
    _NOT_EQUAL,
    _AND,
    _OR,
    _NOT,
    _SQUARE_ROOT,
    _HYPOTENUSE,
    _SINE,
    _COSINE,
    _TANGENT,
    _ARC_SINE,
    _ARC_COSINE,
    _ARC_TANGENT,
    _ARC_TANGENT_2,
    _EXPONENTIAL,
    _LOGARITHM,
    _LOGARITHM_2,
    _LOGARITHM_10,
    _FLOOR,
    _CEILING,
    _TRUNCATE,
    _ROUND,
    _ROUND_DIGITS,
    _COPY_SIGN,
    _REMAINDER,
    _NORMALISE,
    _IN_SECTOR,
    _IN_RECTANGLE,
    _RECTANGLES_MEET,
    _SECTOR_MEETS,
    _IN_RINGS,
    _DRAW,
    _CUT,
    _QUANTILE,
    _SORT,
    _REJECT,
    _TERMINATE,
    _FAULT,
    _FAULT_UNLESS,
    _IS_INDEX,
    _AGAIN,
    _COPY_MANY,
) = map(int, Op)


@kernel
def stop(registers, fault, row):
    """Note what went wrong and where; the first fault of a match stays."""
    if registers[FAULT] == 0:
        registers[FAULT] = fault
        registers[FAULT_ROW] = row


@kernel
def run_thread(code, registers, commands, thread, holder):
    """Resume one thread until it lets time pass, ends or fails. `holder.random` is the match's stream."""
    rows, lists = code.rows, code.lists
    thing = code.threads[thread, 1]
    at = int(registers[code.threads[thread, 0]])
    if at == 0:
        return
    rounds = 0
    for _ in range(MOST_ROWS):
        op, a, b, c = rows[at, 0], rows[at, 1], rows[at, 2], rows[at, 3]
        at += 1
        if op == _COPY:
            registers[a] = registers[b]
        elif op == _ADD:
            registers[a] = registers[b] + registers[c]
        elif op == _SUBTRACT:
            registers[a] = registers[b] - registers[c]
        elif op == _MULTIPLY:
            registers[a] = registers[b] * registers[c]
        elif op == _DIVIDE:
            if registers[c] == 0:
                stop(registers, ZERO, at - 1)
                return
            registers[a] = registers[b] / registers[c]
        elif op == _JUMP:
            at = c
        elif op == _JUMP_IF:
            if registers[a] != 0:
                at = c
        elif op == _JUMP_UNLESS:
            if registers[a] == 0:
                at = c
        elif op == _JUMP_LESS:
            if registers[a] < registers[b]:
                at = c
        elif op == _JUMP_NOT_LESS:
            if not registers[a] < registers[b]:
                at = c
        elif op == _JUMP_LESS_EQUAL:
            if registers[a] <= registers[b]:
                at = c
        elif op == _JUMP_NOT_LESS_EQUAL:
            if not registers[a] <= registers[b]:
                at = c
        elif op == _JUMP_EQUAL:
            if registers[a] == registers[b]:
                at = c
        elif op == _JUMP_NOT_EQUAL:
            if registers[a] != registers[b]:
                at = c
        elif op == _AGAIN:
            rounds += 1
            if rounds > PATIENCE:
                stop(registers, ENDLESS, at - 1)
                return
            at = c
        elif op == _TAKE:
            commands[thing] = registers[a]
            registers[b] = c
            return
        elif op == _WAIT:
            registers[b] = c
            return
        elif op == _SET_SLOT:
            registers[a] = c
        elif op == _RESUME:
            at = int(registers[a])
        elif op == _RESUME_IF_RUNNING:
            if registers[a] != 0:
                at = int(registers[a])
        elif op == _PICK:
            place = int(registers[b])
            if place < 0 or place >= lists[c - 1]:
                stop(registers, INDEX, at - 1)
                return
            registers[a] = registers[lists[c + place]]
        elif op == _FETCH:
            registers[a] = registers[b + int(registers[c])]
        elif op == _STORE:
            registers[a + int(registers[b])] = registers[c]
        elif op == _LESS:
            registers[a] = registers[b] < registers[c]
        elif op == _LESS_EQUAL:
            registers[a] = registers[b] <= registers[c]
        elif op == _EQUAL:
            registers[a] = registers[b] == registers[c]
        elif op == _NOT_EQUAL:
            registers[a] = registers[b] != registers[c]
        elif op == _AND:
            registers[a] = registers[b] != 0 and registers[c] != 0
        elif op == _OR:
            registers[a] = registers[b] != 0 or registers[c] != 0
        elif op == _NOT:
            registers[a] = registers[b] == 0
        elif op == _HYPOTENUSE:
            registers[a] = math.hypot(registers[b], registers[c])
        elif op == _NORMALISE:
            registers[a] = registers[b] - TURN * np.rint(registers[b] / TURN)
        elif op == _ARC_TANGENT_2:
            registers[a] = math.atan2(registers[b], registers[c])
        elif op == _NEGATE:
            registers[a] = -registers[b]
        elif op == _ABSOLUTE:
            registers[a] = abs(registers[b])
        elif op == _MINIMUM:
            registers[a] = registers[c] if registers[c] < registers[b] else registers[b]
        elif op == _MAXIMUM:
            registers[a] = registers[c] if registers[c] > registers[b] else registers[b]
        elif op == _SINE:
            registers[a] = math.sin(registers[b])
        elif op == _COSINE:
            registers[a] = math.cos(registers[b])
        elif op == _DRAW:
            registers[a] = registers[b] + registers[c] * uniform(holder)
        elif op == _CUT:
            registers[a] = cut(registers[b], registers, lists, c)
        elif op == _IN_SECTOR:
            registers[a] = in_sector(
                registers[lists[c]],
                registers[lists[c + 1]],
                registers[lists[c + 2]],
                registers[lists[c + 3]],
                registers[lists[c + 4]],
            )
        elif op == _IN_RECTANGLE:
            registers[a] = in_rectangle(registers, lists, c)
        elif op == _END:
            registers[a] = 0
            return
        elif op == _TERMINATE:
            registers[TERMINATED] = registers[a]
            registers[b] = c
            return
        elif op == _REJECT:
            registers[REJECTED] = c
            return
        elif op == _FAULT:
            stop(registers, OWN, at - 1)
            return
        elif op == _FAULT_UNLESS:
            if registers[a] == 0:
                stop(registers, OWN, at - 1)
                return
        elif op == _IS_INDEX:
            registers[a] = 0 <= registers[b] < registers[c] and registers[b] == np.floor(registers[b])
        elif op == _COPY_MANY:
            for i in range(c):
                registers[a + i] = registers[b + i]
        elif op == _SORT:
            sort_order(registers, a, b, int(registers[c]))
        elif op in (_FLOOR_DIVIDE, _MODULO, _REMAINDER):
            if registers[c] == 0:
                stop(registers, ZERO if op != _REMAINDER else DOMAIN, at - 1)
                return
            registers[a] = divided(op, registers[b], registers[c])
        else:
            result, fine = computed(code, registers, op, b, c)
            if not fine:
                stop(registers, ZERO if op == _POWER and registers[b] == 0 else DOMAIN, at - 1)
                return
            registers[a] = result
    stop(registers, ENDLESS, at - 1)


@kernel
def divided(op, x, y):
    """The divisions that round, of which none is by 0."""
    if op == _REMAINDER:
        return np.fmod(x, y)
    rest = np.fmod(x, y)
    if rest != 0 and (rest < 0) != (y < 0):
        rest += y
    if op == _MODULO:
        return rest if rest != 0 else math.copysign(0.0, y)
    quotient = (x - rest) / y
    if quotient == 0:
        return math.copysign(0.0, x / y)
    floor = math.floor(quotient)
    return floor + 1.0 if quotient - floor > 0.5 else float(floor)


@kernel
def computed(code, registers, op, b, c):
    """The rarer functions: the result, and whether there is one. Integers have no -0, hence `+ 0.0`."""
    x = registers[b]
    if op == _POWER:
        return power(x, registers[c])
    if op == _SQUARE_ROOT:
        return math.sqrt(max(x, 0.0)), x >= 0
    if op == _FLOOR:
        return np.floor(x) + 0.0, np.isfinite(x)
    if op == _CEILING:
        return np.ceil(x) + 0.0, np.isfinite(x)
    if op == _TRUNCATE:
        return np.trunc(x) + 0.0, np.isfinite(x)
    if op == _ROUND:
        return np.rint(x) + 0.0, np.isfinite(x)
    if op == _ROUND_DIGITS:
        scale = 10.0 ** registers[c]
        return np.rint(x * scale) / scale, True
    if op == _TANGENT:
        return math.tan(x), True
    if op == _ARC_SINE:
        return math.asin(min(max(x, -1.0), 1.0)), abs(x) <= 1
    if op == _ARC_COSINE:
        return math.acos(min(max(x, -1.0), 1.0)), abs(x) <= 1
    if op == _ARC_TANGENT:
        return math.atan(x), True
    if op == _EXPONENTIAL:
        return math.exp(min(x, 709.0)), x <= 709.0
    if op == _LOGARITHM:
        return math.log(max(x, 1e-300)), x > 0
    if op == _LOGARITHM_2:
        return math.log2(max(x, 1e-300)), x > 0
    if op == _LOGARITHM_10:
        return math.log10(max(x, 1e-300)), x > 0
    if op == _COPY_SIGN:
        return math.copysign(x, registers[c]), True
    if op == _RECTANGLES_MEET:
        return (1.0 if rectangles_meet(registers, code.lists, c) else 0.0), True
    if op == _SECTOR_MEETS:
        return (1.0 if sector_meets(registers, code.lists, c) else 0.0), True
    if op == _IN_RINGS:
        return (1.0 if in_rings(registers, code.lists, c) else 0.0), True
    if op == _QUANTILE:
        return quantile(x), True
    return 0.0, False


@kernel
def run_threads(code, registers, commands, first, count, holder):
    """Resume some threads, in order, as long as nothing is broken."""
    for thread in range(first, first + count):
        if registers[FAULT] != 0 or registers[REJECTED] != 0:
            return
        run_thread(code, registers, commands, thread, holder)


@kernel
def step_scenario(code, registers, commands, holder):
    """The scenario takes one step at each time, by whatever it is asked for first."""
    if registers[SEEN] < registers[code.clock]:
        registers[SEEN] = registers[code.clock]
        run_threads(code, registers, commands, 0, code.scenarios, holder)


@kernel
def end(code, registers, commands, holder):
    """The match ends: it is rejected if that leaves a requirement unsatisfied."""
    run_threads(code, registers, commands, code.threads.shape[0] - 1, 1, holder)


@kernel
def over(registers):
    """Whether a match has ended, is broken or has failed."""
    return registers[TERMINATED] != 0 or registers[REJECTED] != 0 or registers[FAULT] != 0


@kernel
def run_behaviors(code, registers, commands, holder):
    """One step of every behavior, in the order of the objects; commands [O] float64, NO_COMMAND where there is none.

    The registers hold the world and the facts of now. Afterwards they say in `TERMINATED`, `REJECTED` and `FAULT`
    whether the match goes on; if not, nobody has a command.
    """
    commands[:] = NO_COMMAND
    if over(registers):
        return
    step_scenario(code, registers, commands, holder)
    if registers[COMPLETE] != 0:
        registers[TERMINATED] = registers[COMPLETE]
    for thread in range(code.scenarios, code.scenarios + code.behaviors):
        if over(registers):
            break
        run_thread(code, registers, commands, thread, holder)
    if over(registers):
        commands[:] = NO_COMMAND
        if registers[TERMINATED] != 0:
            end(code, registers, commands, holder)


@kernel
def run_watchers(code, registers, holder):
    """One step of all that watches a match; returns the reward and clears it.

    First what is recorded, then the monitors, then the conditions that end the match.
    """
    if over(registers):
        return 0.0
    step_scenario(code, registers, registers, holder)
    first = code.scenarios + code.behaviors
    run_threads(code, registers, registers, first, code.records, holder)
    first += code.records
    if registers[COMPLETE] == 0 or code.parting:
        run_threads(code, registers, registers, first, code.monitors, holder)
    if registers[TERMINATED] == 0:
        if registers[COMPLETE] != 0:
            registers[TERMINATED] = registers[COMPLETE]
        else:
            run_threads(code, registers, registers, first + code.monitors, 1, holder)
    if registers[TERMINATED] != 0:
        end(code, registers, registers, holder)
    reward = registers[REWARD]
    registers[REWARD] = 0.0
    return reward
