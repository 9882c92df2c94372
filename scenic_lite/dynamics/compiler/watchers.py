"""What watches a match: the guards at its start, temporal requirements, `terminate when`, `terminate after`.

A temporal requirement is a small automaton: what remains to be required after a step (`temporal`) is its state, the
truths of the expressions that the state mentions choose the next one. Read next: `compiler`.
"""

from __future__ import annotations

from itertools import product

from scenic_lite.dynamics.bytecode import COMPLETE, TERMINATED, Op
from scenic_lite.dynamics.compiler.behaviors import check_guards, frame_of
from scenic_lite.dynamics.compiler.code import Label, Live, Operands
from scenic_lite.dynamics.compiler.conditions import jump_on, needs_number
from scenic_lite.dynamics.compiler.emit import register_of
from scenic_lite.dynamics.compiler.frame import Compilation, LiveFrame, Scope
from scenic_lite.dynamics.temporal import Formula, Settled, formula_of
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation.frame import Watched
from scenic_lite.syntax import nodes
from scenic_lite.values import BehaviorCall, Instance

MOST_STATES = 64  # of one temporal requirement
MOST_ATOMS = 8  # expressions that one state asks for


def start(c: Compilation, calls: list[tuple[Instance | None, BehaviorCall]]) -> None:
    """The guards of all behaviors and monitors, before any of them runs."""
    for agent, call in calls:
        c.agent = agent
        with c.round(call.behavior.node, len(c.broken)), c.entered(call.behavior, call.behavior.node):
            c.code.place = call.place
            check_guards(c, frame_of(c, call))
    c.agent = None


def frame_for(c: Compilation, watched: Watched) -> LiveFrame:
    """The names that a statement outside of behaviors sees."""
    c.code.place = watched.place
    scope = Scope((*c.path, id(watched.tree)), [], Label())
    return LiveFrame(c, watched.frame.source, {}, watched.frame, scope)


# ------------------------------------------------------------ ends


def time_limit(c: Compilation) -> None:
    """`terminate after`: the last one counts; the scenario has taken as many steps as there were steps of time."""
    limits = [each for each in c.program.terminations if isinstance(each.tree, nodes.TerminateAfter)]
    for watched in limits[-1:]:
        duration = needs_number(frame_for(c, watched).value(watched.tree.duration), "a duration")
        steps = duration if watched.tree.unit == "steps" else duration / c.world.timestep
        first, on, passed = c.code.variables.take(), Label(), c.code.temporaries.take()
        c.code.row(Op.JUMP_IF, first, c=on)
        c.code.row(Op.ADD, first, c.time().register, c.code.constant(1))  # 0: not yet begun
        c.code.put(on)
        c.code.row(Op.SUBTRACT, passed, c.time().register, first)
        c.code.row(Op.ADD, passed, passed, c.code.constant(1))
        going = Label()
        c.code.row(Op.JUMP_LESS, passed, register_of(c.code, steps), going)
        register_of(c.code, Live(c.reason("scenarioComplete: reached time limit")), COMPLETE)
        c.code.put(going)


def ends_of_scenario(c: Compilation) -> None:
    """Its time limit, then its conditions."""
    time_limit(c)
    conditions(c, "scenario")


def conditions(c: Compilation, scope: str) -> None:
    """`terminate when`, `terminate simulation when`: the first that is true."""
    end = Label()
    kind, register = ("scenarioComplete", COMPLETE) if scope == "scenario" else (SIMULATION, TERMINATED)
    all_ = c.program.terminations
    wanted = [each for each in all_ if isinstance(each.tree, nodes.TerminateWhen) and each.tree.scope == scope]
    if wanted:
        c.code.row(Op.JUMP_IF, register, c=end)
    for watched in wanted:
        frame, no = frame_for(c, watched), Label()
        with c.code.statement():
            jump_on(c, frame, watched.tree.condition, no, when=False)
            register_of(c.code, Live(c.reason(f"{kind}: {watched.label}")), register)
            c.code.row(Op.JUMP, c=end)
            c.code.put(no)
    c.code.put(end)


SIMULATION = "simulationTerminationCondition"

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


def temporal(c: Compilation) -> list[tuple[Watched, Automaton, int]]:
    """Rows that let each temporal requirement see the step; returns what the end must ask."""
    made = []
    for watched in c.program.temporal:
        automaton = Automaton(formula_of(watched.tree.condition))
        state = c.code.variables.take()
        with watched.bindings.restored(), c.code.statement():
            see_step(c, watched, automaton, state)
        made.append((watched, automaton, state))
    return made


def see_step(c: Compilation, watched: Watched, automaton: Automaton, state: int) -> None:
    code, frame = c.code, frame_for(c, watched)
    end = Label()
    for number, (atoms, following) in enumerate(zip(automaton.atoms, automaton.next, strict=True)):
        if isinstance(automaton.states[number], Settled):
            continue
        other = Label()
        code.row(Op.JUMP_NOT_EQUAL, state, code.constant(number), other)
        index = code.temporaries.take()
        register_of(code, 0, index)
        for atom in atoms:
            no = Label()
            code.row(Op.ADD, index, index, index)
            with code.statement():
                jump_on(c, frame, atom, no, when=False)
            code.row(Op.ADD, index, index, code.constant(1))
            code.put(no)
        code.row(Op.PICK, state, index, Operands(tuple(code.constant(each) for each in following)))
        code.row(Op.JUMP, c=end)
        code.put(other)
    code.put(end)
    refuse(c, watched, state, [i for i, each in enumerate(automaton.states) if each == Settled(False)])


def unsatisfied(c: Compilation, made: list[tuple[Watched, Automaton, int]]) -> None:
    """At the end of a match: what was required and has not come."""
    for watched, automaton, state in made:
        c.code.place = watched.place
        refuse(c, watched, state, [i for i, each in enumerate(automaton.states) if not each.at_end()])


def refuse(c: Compilation, watched: Watched, state: int, bad: list[int]) -> None:
    """Reject the match in some states."""
    for number in bad:
        fine = Label()
        c.code.row(Op.JUMP_NOT_EQUAL, state, c.code.constant(number), fine)
        c.reject(watched.label)
        c.code.put(fine)
