"""What watches a match: guards at its start, temporal requirements, `terminate when`, `terminate after`, `record`.

A temporal requirement is a small automaton: what remains to be required after a step (`temporal`) is its state, the
truths of the expressions that the state mentions choose the next one. Read next: `dynamics.compiler.compile`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from itertools import product

from scenic_lite.core.state import Watched
from scenic_lite.core.types import BehaviorCall, Instance, RandomChoice
from scenic_lite.dynamics.compiler.choices import branch, needs_number
from scenic_lite.dynamics.compiler.code import Label, Operands
from scenic_lite.dynamics.compiler.compilation import Compilation, CompiledScope, InlinedBody
from scenic_lite.dynamics.compiler.emit import is_whole, register_of
from scenic_lite.dynamics.compiler.interrupts import check_guards, frame_of
from scenic_lite.dynamics.compiler.parts import ScenarioInstance, Temporal, WatchedItem
from scenic_lite.dynamics.compiler.registers import store_in_register
from scenic_lite.dynamics.compiler.types import RegisterList, flatten, unflatten
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.dynamics.machine.bytecode import TERMINATED
from scenic_lite.dynamics.machine.compiled import Record
from scenic_lite.dynamics.machine.register_values import Listed, RegisterValue
from scenic_lite.errors import ScenicError
from scenic_lite.language.temporal import Formula, Settled
from scenic_lite.syntax import nodes
from scenic_lite.values.graph import RandomExpr, Value

MOST_STATES = 64  # of one temporal requirement
MOST_ATOMS = 8  # expressions that one state asks for


def start(c: Compilation, main: ScenarioInstance, calls: list[tuple[Instance | None, BehaviorCall]]) -> None:
    """Check before all else the guards of the main scenario, of behaviors and of monitors; note the time limit."""
    if main.scope is not None:
        check_guards(c, main.scope)
    limit_of(c, main)
    for agent, call in calls:
        node, number = call.behavior.node, len(c.output.rejections)
        with c.acting(agent), c.round(node, number), c.entered(call.behavior, node):
            c.code.place = call.place
            check_guards(c, frame_of(c, call))


def frame_for(c: Compilation, watched: Watched) -> CompiledScope:
    """Return the names that a statement outside of behaviors sees."""
    c.code.place = watched.place
    inlined = InlinedBody((*c.site.path, id(watched.tree)), Label())
    return CompiledScope(c, watched.scope.source, {}, watched.scope, inlined)


# ------------------------------------------------------------ ends


def limit_of(c: Compilation, part: ScenarioInstance) -> None:
    """Note the time limit of a scenario that begins, from `terminate after`; the last one counts."""
    code = c.code
    limits = [each for each in part.terminations if isinstance(each.watched.tree, nodes.TerminateAfter)]
    if not limits:
        return
    taken, allowed = part.limit = code.fixed.take(), code.fixed.take()
    register_of(code, 0, taken)
    register_of(code, math.inf, allowed)
    for each in limits:
        tree, duration = each.watched.tree, each.watched.duration  # of the scene, if it has one
        with while_noted(c, each):
            if duration is None:
                duration = frame_for(c, each.watched).value(tree.duration)
            needs_number(duration, "a duration")
            register_of(code, duration if tree.unit == "steps" else duration / c.world.timestep, allowed)


def while_noted(c: Compilation, item: WatchedItem) -> AbstractContextManager[None]:
    """Rows written inside are for a statement that the match has come to."""
    return nullcontext() if item.flag is None else c.code.when(item.flag)


def conditions(c: Compilation, part: ScenarioInstance, extent: str, end: Callable[[str], None]) -> None:
    """Compile `terminate [simulation] when`: end something with the label of the first that holds."""
    for each in part.terminations:
        tree = each.watched.tree
        if isinstance(tree, nodes.TerminateWhen) and tree.scope == extent:
            scope = frame_for(c, each.watched)
            with c.code.statement(), while_noted(c, each), branch(c, scope, tree.condition):
                end(each.watched.label)


def ends_of_match(c: Compilation, main: ScenarioInstance) -> None:
    """Compile `terminate simulation when` of all scenarios that run."""
    done = Label()

    def end(label: str) -> None:
        register_of(c.code, RegisterValue(c.reason(f"simulationTerminationCondition: {label}")), TERMINATED)
        c.code.row(op.JUMP, c=done)

    for i, part in enumerate(main.family()):
        with while_running(c, part, i):
            conditions(c, part, "simulation", end)
    c.code.put(done)


@contextmanager
def while_running(c: Compilation, part: ScenarioInstance, number: int) -> Iterator[None]:
    """Rows written inside are for a scenario while it runs."""
    running = nullcontext() if part.parent is None else c.code.when(part.running)
    with running, c.within(part), c.numbered(number):
        yield


# ------------------------------------------------------------ records


def record(c: Compilation, main: ScenarioInstance, when: str) -> None:
    """Put the values of the `record` statements of one kind into registers, with the time at which that was."""
    code = c.code
    for i, part in enumerate(main.family() if when != "final" else [main]):
        with while_running(c, part, i):
            for each in part.records:
                if each.watched.tree.when == when:
                    with code.statement():
                        take_record(c, each)


def take_record(c: Compilation, item: WatchedItem) -> None:
    code, tree, label = c.code, item.watched.tree, item.watched.label
    with while_noted(c, item):
        value = in_registers(c, store_in_register(code, frame_for(c, item.watched).value(tree.value)))
        taken = code.fixed.take()
        code.begin_with(taken, -1)
        code.notes[taken] = f"{label}.taken"
        register_of(code, c.time(), taken)
        c.output.records.append(Record(label, tree.when, taken, value))


def in_registers(c: Compilation, value: Value) -> Value:
    """Return a value whose random parts all stand in registers, also those of the scene; a list in full."""
    if isinstance(value, RegisterList):
        capacity = 0 if value.type.element is None else value.type.capacity
        return Listed(value.length, [in_registers(c, value.at(i)) for i in range(capacity)])
    if isinstance(value, RandomChoice):
        return RandomChoice(in_registers(c, value.index), tuple(in_registers(c, each) for each in value.options))
    apart = flatten(value)
    if apart is not None:
        return unflatten(apart[0], [in_registers(c, each) for each in apart[1]])
    if isinstance(value, RandomExpr) and not isinstance(value, RegisterValue):
        return RegisterValue(register_of(c.code, value), value.kind, is_whole(value))
    return value


def forget_records(c: Compilation) -> None:
    """Forget what has been recorded in the last step."""
    for each in c.output.records:
        if each.when == "each":
            register_of(c.code, -1, each.taken)


# ------------------------------------------------------------ temporal requirements


class Automaton:
    """The states of a temporal requirement, in the order in which they were found."""

    def __init__(self, formula: Formula) -> None:
        self.states: list[Formula] = [formula]
        self.atoms: list[list] = []
        self.next: list[list[int]] = []
        for state in self.states:  # grows while it is gone through
            self._explore(state)

    def _explore(self, state: Formula) -> None:
        atoms: list = []

        def note(expression) -> bool:
            if expression not in atoms:
                atoms.append(expression)
            return True

        state.after(note)
        if len(atoms) > MOST_ATOMS:
            raise ScenicError("unsupported", f"a temporal requirement of more than {MOST_ATOMS} conditions at once")
        following = []
        for truths in product((False, True), repeat=len(atoms)):
            known = dict(zip(atoms, truths, strict=True))
            following.append(self._number(state.after(known.__getitem__)))
        self.atoms.append(atoms)
        self.next.append(following)

    def _number(self, state: Formula) -> int:
        if state not in self.states:
            self.states.append(state)
            if len(self.states) > MOST_STATES:
                raise ScenicError("unsupported", "a temporal requirement of this size")
        return self.states.index(state)


def see_step(c: Compilation, each: Temporal) -> None:
    """Write rows that let a temporal requirement see the step."""
    scope = each.scope or frame_for(c, each.watched)
    with each.watched.bindings.restored(c.state) if each.watched.bindings is not None else nullcontext():
        progress(c, each, scope)


def progress(c: Compilation, each: Temporal, scope: CompiledScope) -> None:
    code, automaton, state = c.code, each.automaton, each.state
    c.code.place = each.watched.place
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
        code.row(op.SELECT, state, index, Operands(tuple(code.constant(each) for each in following)))
        code.row(op.JUMP, c=end)
        code.put(other)
    code.put(end)
    refuse(c, each.watched, state, [i for i, each in enumerate(automaton.states) if each == Settled(False)])


def unsatisfied(c: Compilation, part: ScenarioInstance) -> None:
    """Reject the match at the end of a scenario for what was required and has not come."""
    for each in part.temporal:
        c.code.place = each.watched.place
        states = each.automaton.states
        refuse(c, each.watched, each.state, [i for i, state in enumerate(states) if not state.at_end()])


def refuse(c: Compilation, watched: Watched, state: int, bad: list[int]) -> None:
    """Reject the match in some states."""
    for number in bad:
        fine = Label()
        c.code.row(op.JUMP_NOT_EQUAL, state, c.code.constant(number), fine)
        c.reject(watched.label)
        c.code.put(fine)
