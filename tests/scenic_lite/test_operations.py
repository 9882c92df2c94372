"""The table of operations: numbers, arrays and the machine agree on every row, and the rest of a row is true."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely

from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.dynamics.machine import vm, vm_geometry
from scenic_lite.dynamics.machine.bytecode import FAULT, FIRST_FREE, Code
from scenic_lite.dynamics.machine.opcodes import NUMBERS, OPCODES
from scenic_lite.values import formulas
from scenic_lite.values.operations import ALWAYS, KEPT, OPERATIONS, row_of
from scenic_lite.values.polygons import Holds

SAMPLES = 400
INTEGERS = (-3, -2, -1, 0, 1, 2, 3, 7)


def titles(rows):
    return [row.name for row in rows]


def samples(row, rng):
    """Return operands for one row, [arity, N]: fractions and integers of either sign, zeros among them."""
    fractions = rng.normal(0, 2, (row.arity, SAMPLES))
    whole = rng.choice(INTEGERS, (row.arity, SAMPLES)).astype(float)
    return np.where(rng.random((row.arity, SAMPLES)) < 0.4, whole, fractions)


def by_machine(opcode, operands):
    """Return the result of one opcode, and whether the machine calls it a fault."""
    count, out = len(operands), FIRST_FREE + 1 + len(operands)
    registers = np.zeros(out + 1)
    registers[FIRST_FREE] = 1  # the thread begins at row 1
    registers[FIRST_FREE + 1 : out] = operands
    places = [FIRST_FREE + 1 + i for i in range(count)]
    if OPCODES[opcode].operands.endswith("l"):
        row, lists = (opcode, out, 0, 1), [count, *places, 0]
    else:
        row, lists = (opcode, out, places[0], places[1] if count > 1 else 0), [0]
    rows = np.array([(op.END, FIRST_FREE, 0, 0), row, (op.END, FIRST_FREE, 0, 0)], dtype=np.uint32)
    threads = np.array([[FIRST_FREE, -1]], dtype=np.int32)
    code = Code(rows, np.array(lists, dtype=np.uint32), threads, 0, 0, 0, 0, False, 0, 0, 0, len(registers))
    vm.run_thread(code, registers, np.zeros(1), 0, np.zeros(1, dtype=[("random", "u8")]).view(np.recarray)[0])
    return registers[out], registers[FAULT] != 0


def by_python(row, operands):
    """Return the result of the row on numbers, None where Python raises or gives no finite number."""
    try:
        result = row.scalar(*operands)
    except (ArithmeticError, ValueError):
        return None
    return result if math.isfinite(result) else None


MACHINE_ROWS = [row for row in OPERATIONS if row.opcode]
NUMBER_ROWS = [row for row in OPERATIONS if row.arity and row.kind != "text"]


@pytest.mark.parametrize("row", NUMBER_ROWS, ids=titles(NUMBER_ROWS))
def test_numbers_and_arrays_agree_and_fail_in_the_same_places(row):
    operands = samples(row, np.random.default_rng(7))
    with np.errstate(all="ignore"):
        together = np.asarray(row.array(*operands))
        fails = (
            np.zeros(SAMPLES, bool) if row.fails is None else np.broadcast_to(row.fails(together, *operands), SAMPLES)
        )
    for i in range(SAMPLES):
        alone = by_python(row, operands[:, i].tolist())
        assert (alone is None) == fails[i], (operands[:, i], alone)
        assert alone is None or math.isclose(alone, together[i], rel_tol=1e-9, abs_tol=1e-12), operands[:, i]


@pytest.mark.slow
@pytest.mark.parametrize("row", MACHINE_ROWS, ids=titles(MACHINE_ROWS))
def test_the_machine_has_a_branch_that_agrees(row):
    operands = samples(row, np.random.default_rng(8))
    for i in range(SAMPLES):
        alone = by_python(row, operands[:, i].tolist())
        result, fault = by_machine(NUMBERS[row.opcode], operands[:: -1 if row.swapped else 1, i])
        assert fault == (alone is None), (operands[:, i], alone, result)
        assert fault or math.isclose(alone, result, rel_tol=1e-9, abs_tol=1e-12), operands[:, i]


@pytest.mark.parametrize("row", NUMBER_ROWS, ids=titles(NUMBER_ROWS))
def test_integers_stay_integers_where_the_row_says_so(row):
    for operands in np.random.default_rng(9).choice(INTEGERS, (60, row.arity)).tolist():
        try:
            result = row.scalar(*operands)
        except (ArithmeticError, ValueError):
            continue
        if row.integers in (KEPT, ALWAYS):
            assert type(result) is int, operands
    if row.integers == ALWAYS:
        assert type(row.scalar(2.5)) is int


def test_no_two_rows_are_one_and_every_opcode_exists():
    assert len({row.array for row in OPERATIONS}) == len(OPERATIONS) == len({row.name for row in OPERATIONS})
    assert all(row_of(row.array) is row for row in OPERATIONS)
    assert {row.opcode for row in MACHINE_ROWS} <= NUMBERS.keys()


# ------------------------------------------------------------ formulas that the machine compiles, and its own


def machine_list(*numbers):
    """Return registers and lists as the machine's geometry takes them, and the place of the operands."""
    return np.array(numbers, dtype=float), np.array([len(numbers), *range(len(numbers))], dtype=np.uint32), 1


@pytest.mark.slow
@pytest.mark.sample(113)
@pytest.mark.parametrize("seed", range(300))
def test_formulas_in_sector_and_the_machines(seed):
    rng = np.random.default_rng(seed)
    sector = (*rng.normal(0, 2, 2), rng.uniform(0, 4), rng.uniform(-7, 7), rng.uniform(0, 7))
    rectangle = (*rng.normal(0, 3, 2), rng.uniform(-7, 7), *rng.uniform(0, 4, 2))
    x, y = rng.normal(0, 2, 2)
    assert bool(formulas.in_sector(x, y, *sector[2:])) == vm_geometry.in_sector(x, y, *sector[2:])
    meets = bool(formulas.sector_meets_rectangle(*sector, *rectangle))
    assert meets == vm_geometry.sector_meets_rectangle(*sector, *rectangle)
    arrays = formulas.sector_meets_rectangle(*(np.array([each, 9.0]) for each in (*sector, *rectangle)))
    assert meets == arrays[0]


def test_formulas_normal_quantile_and_the_machines():
    for uniform in (0.0, 1.0, 1e-300, 2.0**-53, 0.5, *np.random.default_rng(0).random(500), *np.geomspace(1e-16, 0.5)):
        assert math.isclose(vm_geometry.quantile(uniform), formulas.normal_quantile(uniform), rel_tol=1e-14)


@pytest.mark.parametrize("seed", range(20))
def test_shapes_hold_points_as_the_machines_rings_do(seed):
    rng = np.random.default_rng(seed)
    star = np.sort(rng.uniform(0, 2 * np.pi, 9))
    outer = np.column_stack([np.cos(star), np.sin(star)]) * rng.uniform(2, 5, (9, 1))
    shape = shapely.difference(shapely.Polygon(outer).buffer(0), shapely.box(-0.5, -0.5, 0.5, 0.7))
    edges: list[float] = []
    for ring in shapely.get_rings(shapely.get_parts(shape)):
        corners = shapely.get_coordinates(ring)
        edges += np.hstack([corners[:-1], corners[1:]]).ravel().tolist()
    points = rng.uniform(-5, 5, (100, 2))
    expected = Holds(shape)(points[:, 0], points[:, 1])
    assert [vm_geometry.in_rings(*machine_list(x, y, *edges)) for x, y in points] == expected.tolist()
