"""Statements that monitor a match: `terminate when`, `terminate after`, `record`, temporal requirements.

A temporal requirement is a small automaton. A state is the remaining requirement after a step
(`language.requirements`). The truth values of the expressions in a state select the next state.
Read next: `dynamics.compiler.layout`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from functools import partial
from itertools import product

from scenic_lite.core.state import EpisodeStatement
from scenic_lite.dynamics.compiler.choices import branch, in_steps
from scenic_lite.dynamics.compiler.code import Label, Operands
from scenic_lite.dynamics.compiler.compilation import (
    Compilation,
    CompiledScope,
    InlinedBody,
    ScenarioInstance,
    WatchedItem,
)
from scenic_lite.dynamics.compiler.emit import is_whole, register_of
from scenic_lite.dynamics.compiler.registers import store_in_register
from scenic_lite.dynamics.compiler.types import RegisterList, builds_text, with_parts
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.dynamics.machine.bytecode import TERMINATED
from scenic_lite.dynamics.machine.compiled import Record
from scenic_lite.dynamics.machine.register_values import Listed, RegisterValue
from scenic_lite.errors import ScenicError
from scenic_lite.language.requirements import Formula, Settled
from scenic_lite.syntax import nodes
from scenic_lite.values.graph import RandomExpr, Value

MOST_STATES = 64  # maximum number of states of one temporal requirement
MOST_ATOMS = 8  # maximum number of expressions in one state


def frame_for(c: Compilation, watched: EpisodeStatement) -> CompiledScope:
    """Return a scope with the names visible to a statement outside behaviors."""
    c.code.place = watched.place
    inlined = InlinedBody((*c.site.path, id(watched.tree)), Label())
    return CompiledScope(c, watched.scope.source, {}, watched.scope, inlined)


@contextmanager
def while_running(c: Compilation, part: ScenarioInstance) -> Iterator[None]:
    """Execute the rows written inside the context only while a scenario runs."""
    with nullcontext() if part.parent is None else c.code.when(part.running), c.within(part):
        yield


# ------------------------------------------------------------ ends
def limit_of(c: Compilation, part: ScenarioInstance) -> None:
    """Store the time limit of a new scenario; the last `terminate after` counts."""
    limits = [item.watched for item in part.terminations if isinstance(item.watched.tree, nodes.TerminateAfter)]
    if limits:
        taken, allowed = part.limit = c.code.fixed.take(), c.code.fixed.take()
        register_of(c.code, 0, taken)
        register_of(c.code, in_steps(c, limits[-1].duration, limits[-1].tree.unit), allowed)


def conditions(c: Compilation, part: ScenarioInstance, extent: str, end: Callable[[str], None]) -> None:
    """Compile `terminate [simulation] when`: call `end` with the label of the first true condition."""
    for item in part.terminations:
        tree = item.watched.tree
        if isinstance(tree, nodes.TerminateWhen) and tree.scope == extent:
            scope = frame_for(c, item.watched)
            with c.code.statement(), branch(c, scope, tree.condition):
                end(item.watched.label)


def ends_of_match(c: Compilation, main: ScenarioInstance) -> None:
    """Compile `terminate simulation when` of all running scenarios."""
    done = Label()

    def end(label: str) -> None:
        register_of(c.code, RegisterValue(c.reason(f"simulationTerminationCondition: {label}")), TERMINATED)
        c.code.row(op.JUMP, c=done)

    for part in main.family():
        with while_running(c, part):
            conditions(c, part, "simulation", end)
    c.code.put(done)


# ------------------------------------------------------------ records
def record(c: Compilation, main: ScenarioInstance, when: str) -> None:
    """Take the records of one kind: "each" in all running scenarios, others only in the program itself."""
    for part in main.family() if when == "each" else [main]:
        with while_running(c, part) if part.records and when != "final" else nullcontext():
            take_records(c, part, when)


def take_records(c: Compilation, part: ScenarioInstance, when: str) -> None:
    """Store the values of a scenario's records of one kind in registers, with the time."""
    for item in part.records:
        if item.watched.tree.when == when:
            with c.code.statement():
                take_record(c, item)


def take_record(c: Compilation, item: WatchedItem) -> None:
    code, tree, label = c.code, item.watched.tree, item.watched.label
    value = frame_for(c, item.watched).value(tree.value)
    outside, code.variables = code.variables, code.fixed
    value = in_registers(c, store_in_register(code, value))
    code.variables = outside
    taken = code.fixed.take()
    code.begin_with(taken, -1)
    code.register_names[taken] = f"{label}.taken"
    register_of(code, c.time(), taken)
    c.output.records.append(Record(label, tree.when, taken, value))


def in_registers(c: Compilation, value: Value) -> Value:
    """Return a value with all random parts in registers, including values of the scene and all elements of a list."""
    if isinstance(value, RegisterList):
        capacity = 0 if value.type.element is None else value.type.capacity
        return Listed(value.length, [in_registers(c, value.at(i)) for i in range(capacity)])
    if isinstance(value, RandomExpr) and not isinstance(value, RegisterValue) and not builds_text(value):
        return RegisterValue(register_of(c.code, value), value.kind, is_whole(value))
    return with_parts(value, partial(in_registers, c))


# ------------------------------------------------------------ temporal requirements
class Automaton:
    """The states of a temporal requirement, in order of discovery."""

    def __init__(self, formula: Formula) -> None:
        self.states: list[Formula] = [formula]
        self.atoms: list[list] = []  # state -> its expressions
        self.next: list[list[int]] = []  # state -> next states, by the truth values of its expressions
        for state in self.states:  # the list grows during the iteration
            atoms: list = []
            state.after(lambda atom, atoms=atoms: atom in atoms or atoms.append(atom) is None)  # type: ignore[misc]
            if len(atoms) > MOST_ATOMS:
                raise ScenicError("unsupported", f"a temporal requirement of more than {MOST_ATOMS} conditions at once")
            steps = [dict(zip(atoms, truths, strict=True)) for truths in product((False, True), repeat=len(atoms))]
            self.atoms.append(atoms)
            self.next.append([self._number(state.after(known.__getitem__)) for known in steps])

    def _number(self, state: Formula) -> int:
        if state not in self.states:
            self.states.append(state)
            if len(self.states) > MOST_STATES:
                raise ScenicError("unsupported", "a temporal requirement of this size")
        return self.states.index(state)


def see_steps(c: Compilation, part: ScenarioInstance) -> None:
    """Write one step of a scenario's temporal requirements."""
    for item in part.temporal:
        bindings = item.watched.bindings
        with c.code.statement(), nullcontext() if bindings is None else bindings.restored(c.state):
            progress(c, item, item.scope or frame_for(c, item.watched))


def progress(c: Compilation, item: WatchedItem, scope: CompiledScope) -> None:
    """Write rows that set the next state of a requirement."""
    code, automaton, state = c.code, item.automaton, item.register
    assert state is not None
    code.place = item.watched.place
    end = Label()
    for number, (atoms, following) in enumerate(zip(automaton.atoms, automaton.next, strict=True)):
        if isinstance(automaton.states[number], Settled):
            continue
        other = Label()
        code.row(op.JUMP_NOT_EQUAL, state, code.constant(number), other)
        index = code.temporaries.take()
        register_of(code, 0, index)
        for atom in atoms:
            code.row(op.ADD, index, index, index)
            with code.statement(), branch(c, scope, atom):
                code.row(op.ADD, index, index, code.constant(1))
        code.row(op.SELECT, state, index, Operands(tuple(code.constant(number) for number in following)))
        code.row(op.JUMP, c=end)
        code.put(other)
    code.put(end)
    refuse(c, item, lambda rest: rest == Settled(False))


def unsatisfied(c: Compilation, part: ScenarioInstance) -> None:
    """Write rows that reject the match if the scenario ends with unsatisfied requirements."""
    for item in part.temporal:
        c.code.place = item.watched.place
        refuse(c, item, lambda rest: not rest.at_end())


def refuse(c: Compilation, item: WatchedItem, bad: Callable[[Formula], bool]) -> None:
    """Write rows that reject the match in the bad states of a requirement."""
    assert item.register is not None
    numbers = [number for number, rest in enumerate(item.automaton.states) if bad(rest)]
    c.code.dispatch(item.register, dict.fromkeys(numbers, partial(c.reject, item.watched.label)))
