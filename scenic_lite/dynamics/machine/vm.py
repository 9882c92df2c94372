"""The virtual machine of compiled behaviors: one loop over rows, which runs a thread until time passes in it.

The machine allocates and decodes nothing; compilation turns the chain of tests into one jump table. The machine does
not depend on football: a match provides registers and receives one command for each object. Read next:
`dynamics.machine.compiled`, which drives it from Python.
"""

from __future__ import annotations

import math

import numpy as np

from regista.kernels.jit import kernel
from regista.kernels.rng import uniform
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.dynamics.machine.bytecode import (
    COMPLETE,
    DIVISION_BY_ZERO,
    DOMAIN_ERROR,
    FAULT,
    FAULT_ROW,
    INDEX_ERROR,
    INFINITE_LOOP,
    MAX_LOOP_ITERATIONS,
    MOST_ROWS,
    NO_COMMAND,
    PROGRAM_ERROR,
    REJECTED,
    REWARD,
    SEEN,
    TERMINATED,
)
from scenic_lite.dynamics.machine.vm_geometry import (
    bucketize,
    five,
    in_rectangle,
    in_rings,
    in_sector,
    power,
    quantile,
    rectangles_meet,
    sector_meets_rectangle,
    sort_order,
)

TURN = 2 * math.pi


@kernel
def stop(registers, fault, row):
    """Store a fault and its row, unless the match already has a fault."""
    if registers[FAULT] == 0:
        registers[FAULT] = fault
        registers[FAULT_ROW] = row


@kernel
def run_thread(code, registers, commands, thread, rng):
    """Resume one thread until it lets time pass, ends or fails. `rng.random` is the random stream of the match."""
    rows, lists = code.rows, code.lists
    obj = code.threads[thread, 1]
    pc = int(registers[code.threads[thread, 0]])
    if pc == 0:
        return
    if not 0 < pc < len(rows):
        stop(registers, INDEX_ERROR, 0)
        return
    rounds = 0
    for _ in range(MOST_ROWS):
        opcode, a, b, c = rows[pc, 0], rows[pc, 1], rows[pc, 2], rows[pc, 3]
        pc += 1
        if opcode == op.COPY:
            registers[a] = registers[b]
        elif opcode == op.ADD:
            registers[a] = registers[b] + registers[c]
        elif opcode == op.SUBTRACT:
            registers[a] = registers[b] - registers[c]
        elif opcode == op.MULTIPLY:
            registers[a] = registers[b] * registers[c]
        elif opcode == op.DIVIDE:
            if registers[c] == 0:
                stop(registers, DIVISION_BY_ZERO, pc - 1)
                return
            registers[a] = registers[b] / registers[c]
        elif opcode == op.JUMP:
            pc = c
        elif opcode == op.JUMP_IF:
            if registers[a] != 0:
                pc = c
        elif opcode == op.JUMP_UNLESS:
            if registers[a] == 0:
                pc = c
        elif opcode == op.JUMP_LESS:
            if registers[a] < registers[b]:
                pc = c
        elif opcode == op.JUMP_NOT_LESS:
            if not registers[a] < registers[b]:
                pc = c
        elif opcode == op.JUMP_LESS_EQUAL:
            if registers[a] <= registers[b]:
                pc = c
        elif opcode == op.JUMP_NOT_LESS_EQUAL:
            if not registers[a] <= registers[b]:
                pc = c
        elif opcode == op.JUMP_EQUAL:
            if registers[a] == registers[b]:
                pc = c
        elif opcode == op.JUMP_NOT_EQUAL:
            if registers[a] != registers[b]:
                pc = c
        elif opcode == op.LOOP_BACK:
            rounds += 1
            if rounds > MAX_LOOP_ITERATIONS:
                stop(registers, INFINITE_LOOP, pc - 1)
                return
            pc = c
        elif opcode == op.TAKE:
            commands[obj] = registers[a]
            registers[b] = c
            return
        elif opcode == op.WAIT:
            registers[b] = c
            return
        elif opcode == op.SET_SLOT:
            registers[a] = c
        elif opcode == op.RESUME or opcode == op.RESUME_IF_RUNNING:
            if opcode == op.RESUME or registers[a] != 0:
                target = int(registers[a])
                if not 0 <= target < len(rows):
                    stop(registers, INDEX_ERROR, pc - 1)
                    return
                pc = target
        elif opcode == op.SELECT:
            place = int(registers[b])
            if place < 0 or place >= lists[c - 1]:
                stop(registers, INDEX_ERROR, pc - 1)
                return
            registers[a] = registers[lists[c + place]]
        elif opcode == op.LOAD_INDEXED or opcode == op.STORE:
            place = a + int(registers[b]) if opcode == op.STORE else b + int(registers[c])
            if not 0 <= place < len(registers):
                stop(registers, INDEX_ERROR, pc - 1)
                return
            if opcode == op.STORE:
                registers[place] = registers[c]
            else:
                registers[a] = registers[place]
        elif opcode == op.LESS:
            registers[a] = registers[b] < registers[c]
        elif opcode == op.LESS_EQUAL:
            registers[a] = registers[b] <= registers[c]
        elif opcode == op.EQUAL:
            registers[a] = registers[b] == registers[c]
        elif opcode == op.NOT_EQUAL:
            registers[a] = registers[b] != registers[c]
        elif opcode == op.AND:
            registers[a] = registers[b] != 0 and registers[c] != 0
        elif opcode == op.OR:
            registers[a] = registers[b] != 0 or registers[c] != 0
        elif opcode == op.NOT:
            registers[a] = registers[b] == 0
        elif opcode == op.HYPOTENUSE:
            registers[a] = math.hypot(registers[b], registers[c])
        elif opcode == op.NORMALISE:
            registers[a] = registers[b] - TURN * np.rint(registers[b] / TURN)
        elif opcode == op.ARC_TANGENT_2:
            registers[a] = math.atan2(registers[b], registers[c])
        elif opcode == op.NEGATE:
            registers[a] = -registers[b]
        elif opcode == op.ABSOLUTE:
            registers[a] = abs(registers[b])
        elif opcode == op.MINIMUM:
            registers[a] = registers[c] if registers[c] < registers[b] else registers[b]
        elif opcode == op.MAXIMUM:
            registers[a] = registers[c] if registers[c] > registers[b] else registers[b]
        elif opcode == op.SINE:
            registers[a] = math.sin(registers[b])
        elif opcode == op.COSINE:
            registers[a] = math.cos(registers[b])
        elif opcode == op.DRAW:
            registers[a] = registers[b] + registers[c] * uniform(rng)
        elif opcode == op.BUCKETIZE:
            registers[a] = bucketize(registers[b], registers, lists, c)
        elif opcode == op.IN_SECTOR:
            registers[a] = in_sector(*five(registers, lists, c))
        elif opcode == op.IN_RECTANGLE:
            registers[a] = in_rectangle(registers[lists[c]], registers[lists[c + 1]], *five(registers, lists, c + 2))
        elif opcode == op.END:
            registers[a] = 0
            return
        elif opcode == op.TERMINATE:
            registers[TERMINATED] = registers[a]
            registers[b] = c
            return
        elif opcode == op.REJECT:
            registers[REJECTED] = c
            return
        elif opcode == op.FAULT:
            stop(registers, PROGRAM_ERROR, pc - 1)
            return
        elif opcode == op.FAULT_UNLESS:
            if registers[a] == 0:
                stop(registers, PROGRAM_ERROR, pc - 1)
                return
        elif opcode == op.IS_INDEX:
            registers[a] = 0 <= registers[b] < registers[c] and registers[b] == np.floor(registers[b])
        elif opcode == op.COPY_MANY:
            for i in range(c):
                registers[a + i] = registers[b + i]
        elif opcode == op.SORT:
            count = int(registers[c])
            if count > len(registers) - max(a, b):
                stop(registers, INDEX_ERROR, pc - 1)
                return
            sort_order(registers, a, b, count)
        elif opcode == op.FLOOR_DIVIDE or opcode == op.MODULO:
            if registers[c] == 0:
                stop(registers, DIVISION_BY_ZERO, pc - 1)
                return
            registers[a] = registers[b] % registers[c] if opcode == op.MODULO else registers[b] // registers[c]
        else:
            result, fine = computed(code, registers, opcode, b, c)
            if not fine:
                stop(registers, DIVISION_BY_ZERO if opcode == op.POWER and registers[b] == 0 else DOMAIN_ERROR, pc - 1)
                return
            registers[a] = result
    stop(registers, INFINITE_LOOP, pc - 1)


@kernel
def computed(code, registers, opcode, b, c):
    """Compute a rare function; return the result and whether it exists. `+ 0.0` avoids -0, which integers lack."""
    x = registers[b]
    if opcode == op.POWER:
        return power(x, registers[c])
    if opcode == op.SQUARE_ROOT:
        return math.sqrt(max(x, 0.0)), x >= 0
    if opcode == op.FLOOR:
        return np.floor(x) + 0.0, np.isfinite(x)
    if opcode == op.CEILING:
        return np.ceil(x) + 0.0, np.isfinite(x)
    if opcode == op.TRUNCATE:
        return np.trunc(x) + 0.0, np.isfinite(x)
    if opcode == op.ROUND:
        return np.rint(x) + 0.0, np.isfinite(x)
    if opcode == op.EXPONENTIAL:
        return math.exp(min(x, 709.0)), x <= 709.0
    if opcode == op.LOGARITHM:
        return math.log(max(x, 1e-300)), x > 0
    if opcode == op.RECTANGLES_MEET:
        sides = five(registers, code.lists, c) + five(registers, code.lists, c + 5)
        return (1.0 if rectangles_meet(*sides) else 0.0), True
    if opcode == op.SECTOR_MEETS:
        sides = five(registers, code.lists, c) + five(registers, code.lists, c + 5)
        return (1.0 if sector_meets_rectangle(*sides) else 0.0), True
    if opcode == op.IN_RINGS:
        return (1.0 if in_rings(registers, code.lists, c) else 0.0), True
    if opcode == op.QUANTILE:
        return float(quantile(x)), True
    return 0.0, False


@kernel
def run_threads(code, registers, commands, first, count, rng):
    """Resume some threads, in order, unless the match is rejected or has failed."""
    for thread in range(first, first + count):
        if registers[FAULT] != 0 or registers[REJECTED] != 0:
            return
        run_thread(code, registers, commands, thread, rng)


@kernel
def step_scenario(code, registers, commands, rng):
    """Run one step of the scenario at the first call in each time step."""
    if registers[SEEN] < registers[code.clock]:
        registers[SEEN] = registers[code.clock]
        run_threads(code, registers, commands, 0, code.scenarios, rng)


@kernel
def end(code, registers, commands, rng):
    """Run the end of the match, which rejects it if a requirement is unsatisfied."""
    run_threads(code, registers, commands, code.threads.shape[0] - 1, 1, rng)


@kernel
def over(registers):
    """Return whether a match has ended, is rejected or has failed."""
    return registers[TERMINATED] != 0 or registers[REJECTED] != 0 or registers[FAULT] != 0


@kernel
def run_behaviors(code, registers, commands, rng):
    """Run one step of every behavior, in the order of the objects; commands [O] float64, NO_COMMAND for none.

    The registers hold the current world and facts. Afterwards `TERMINATED`, `REJECTED` and `FAULT` indicate whether the
    match continues; if it does not, no object has a command.
    """
    commands[:] = NO_COMMAND
    if over(registers):
        return
    step_scenario(code, registers, commands, rng)
    if registers[COMPLETE] != 0:
        registers[TERMINATED] = registers[COMPLETE]
    for thread in range(code.scenarios, code.scenarios + code.behaviors):
        if over(registers):
            break
        run_thread(code, registers, commands, thread, rng)
    if over(registers):
        commands[:] = NO_COMMAND
        if registers[TERMINATED] != 0:
            end(code, registers, commands, rng)


@kernel
def run_watchers(code, registers, rng):
    """Run one step of all statements that monitor a match; return and clear the reward.

    The order is: records, monitors, conditions that end the match.
    """
    if over(registers):
        return 0.0
    step_scenario(code, registers, registers, rng)
    first = code.scenarios + code.behaviors
    run_threads(code, registers, registers, first, code.records, rng)
    first += code.records
    if registers[COMPLETE] == 0 or code.parting:
        run_threads(code, registers, registers, first, code.monitors, rng)
    if registers[TERMINATED] == 0:
        if registers[COMPLETE] != 0:
            registers[TERMINATED] = registers[COMPLETE]
        else:
            run_threads(code, registers, registers, first + code.monitors, 1, rng)
    if registers[TERMINATED] != 0:
        end(code, registers, registers, rng)
    reward = registers[REWARD]
    registers[REWARD] = 0.0
    return reward
