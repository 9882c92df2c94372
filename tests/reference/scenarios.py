"""Scenarios while an episode runs: the program's own, and those that compose blocks start.

A scenario starts in this order: its guards are checked, its setup is executed (objects are made and draws done at
once), its time limit is computed, the behaviors of its objects start in the order of their making, its monitors start.
Of the program's scenario the setup was executed when the program was loaded, and its guards are checked at the start.

One step of a scenario, outer ones before the inner ones that their compose blocks run:

1. its temporal requirements see the step; one that is false rejects the episode;
2. its time limit (`terminate after n`): reached after n steps of its own;
3. its compose block goes on until it lets time pass, which is where its sub-scenarios take their steps; if it has
   ended, so has the scenario;
4. its conditions `terminate when`, in the order of the text.

In a compose block `do` runs scenarios, several at once if it names several: all are set up and started one after the
other in the order of the text, then each takes a step; from then on one step each, until all have ended. `do A() until
c` stops them when c is true; so does an `abort`. A scenario that ends stops its monitors and sub-scenarios, gives back
what it had overridden, and rejects the episode if a temporal requirement does not hold. Each scenario has its own
`ego`, at first that of its parent. Read next: `dynamics.reference.threads`.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from contextlib import contextmanager
from dataclasses import replace

from scenic_lite.core.scope import Scope
from scenic_lite.core.state import EpisodeStatement
from scenic_lite.core.types import BehaviorCall, Instance
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation.calls import scenario_frame
from scenic_lite.language.requirements import FALSE, Check, formula_of
from scenic_lite.syntax import nodes
from scenic_lite.values.graph import Value
from tests.reference.episode import Episode, Rejected, sampled
from tests.reference.threads import Agents, End, Step, Thread

KEPT = ("monitors", "terminations", "records", "temporal")


class ComposeThread(Thread):
    """The compose block of a scenario. A scenario with guards and no compose block waits, and checks its guards."""

    def __init__(self, episode: Episode, call: BehaviorCall, scenario: Scenario) -> None:
        super().__init__(episode, call)
        self.scenario = scenario
        self.ended = False

    def _scope(self) -> Scope:
        return scenario_frame(self.episode.mode, self.call)

    def start(self) -> None:
        """Stand before the first statement; the guards were checked before the setup."""
        self._steps = self.run()

    def run(self) -> Iterator[Step]:
        if self.call.behavior.scenario.compose:
            yield from super().run()
            self.ended = True
            return
        while True:
            yield ()
            self.check_invariants()

    def seen_from_call(self, error: ScenicError) -> ScenicError:
        return error if self.scenario.parent is None else super().seen_from_call(error)

    def close(self) -> None:
        """Give the block up."""
        if isinstance(self._steps, Generator):
            self._steps.close()
        self.ended = True

    def inner(self, call: BehaviorCall) -> Thread:
        return ComposeThread(self.episode, replace(call, names={}), self.scenario)

    def invoked(self, calls: list[BehaviorCall]) -> Iterator[Step]:
        """Run scenarios at the same time until all have ended."""
        subs: list[Scenario] = []
        try:
            for call in calls:
                subs.append(self.scenario.begin(call))
            while True:
                for sub in subs:
                    end = sub.step() if sub.running else None
                    if isinstance(end, End) and end.scope == "simulation":
                        yield end
                subs = [sub for sub in subs if sub.running]
                if not subs:
                    return
                yield ()
                subs = [sub for sub in subs if sub.running]
        except Rejected:
            subs = []  # the episode is over: what it leaves unsatisfied counts no more
            raise
        finally:
            self.scenario.finish(subs)


class Scenario:
    """One running scenario; `parent` is None for the program's own."""

    def __init__(self, episode: Episode, agents: Agents, call: BehaviorCall | None, parent: Scenario | None) -> None:
        self.episode, self.agents, self.parent = episode, agents, parent
        self.compose: ComposeThread | None = None if call is None else ComposeThread(episode, call, self)
        self.ego = episode.state.ego
        self.objects: list[Instance] = []
        self.subs: list[Scenario] = []
        self.running = False
        self._monitors: list[Thread] = []
        self._temporal: list[tuple[EpisodeStatement, Check]] = []
        self._overridden: dict[tuple[Instance, str], Value] = {}
        self._elapsed = 0
        self._limit: float | None = None
        self.kept: dict[str, list] = {name: [] for name in KEPT}

    def import_loaded(self) -> None:
        """Take over what loading the program has made."""
        program = self.episode.program
        self.kept = {name: list(vars(program)[name]) for name in KEPT}
        self.objects = list(self.episode.objects)
        if self.compose is not None and program.main_frame is not None:
            self.compose.scope = self.episode.scope(program.main_frame)  # its setup has been executed

    def set_up(self) -> None:
        """Check the guards and execute the setup, inside the parent."""
        assert self.compose is not None
        state = self.episode.state
        state.clear_episode_statements()
        before = len(state.objects)
        with self.current():
            try:
                self.compose.check_guards()
                self.compose.scope.run(self.compose.call.behavior.scenario.setup)
            except ScenicError as error:
                raise self.compose.seen_from_call(error) from None
        self.kept = {name: vars(state)[name] for name in KEPT}
        self.objects = state.objects[before:]
        for instance in self.objects:
            row = self.episode.row
            instance.properties = {name: sampled(value, row) for name, value in instance.properties.items()}
            instance.properties.setdefault("lastActions", ())

    def start(self) -> None:
        """Begin: guards of the program's own scenario, then all that runs."""
        self.running = True
        for watched in self.kept["temporal"]:
            self.add_temporal(watched)
        with self.current():
            if self.compose is not None:
                if self.parent is None:  # its setup was executed when the program was loaded
                    self.compose.check_guards()
                self.compose.start()
            self._limit = self._time_limit()
            for instance in self.objects:
                self.agents.belongs(instance, self.end_by)
            for instance in self.objects:
                if instance.properties["behavior"] is not None:
                    self.agents.assign(instance)
            for call in self.kept["monitors"]:
                self.add_monitor(call)

    def begin(self, call: BehaviorCall) -> Scenario:
        """Set up and start a scenario inside this one."""
        sub = Scenario(self.episode, self.agents, call, self)
        sub.set_up()
        sub.start()
        self.episode.records.update(sub.own_records("initial"))
        self.subs.append(sub)
        return sub

    def finish(self, subs: list[Scenario]) -> None:
        """Stop what still runs of scenarios inside this one, and forget those that have ended."""
        if not self.episode.active:
            return  # a block is given up because nobody plays the episode on
        for sub in subs:
            if sub.running:
                sub.stop()
        self.subs = self._running()

    def add_monitor(self, call: BehaviorCall) -> None:
        thread = Thread(self.episode, call)
        thread.start()
        self._monitors.append(thread)

    def add_temporal(self, watched: EpisodeStatement) -> None:
        """Watch a temporal requirement from the next step on."""
        self._temporal.append((watched, Check(formula_of(watched.tree.condition))))

    def _time_limit(self) -> float | None:
        limits = [item for item in self.kept["terminations"] if isinstance(item.tree, nodes.TerminateAfter)]
        if not limits:
            return None
        tree, scope = limits[-1].tree, self._scope_of(limits[-1])
        return self.episode.in_steps(sampled(limits[-1].duration, self.episode.row), scope, tree.duration, tree.unit)

    @contextmanager
    def current(self) -> Iterator[None]:
        """Let `ego` be that of this scenario inside."""
        state = self.episode.state
        before, state.ego = state.ego, self.ego
        outer, self.episode.scenario = self.episode.scenario, self
        try:
            yield
        finally:
            self.ego, state.ego, self.episode.scenario = state.ego, before, outer
            self._share_ego()

    def _share_ego(self) -> None:
        """Give scenarios around this one that have no ego the first one there is."""
        around = self.parent
        while around is not None and around.ego is None and self.ego is not None:
            around.ego = self.ego
            if self.episode.scenario is around:
                self.episode.state.ego = self.ego
            around = around.parent

    def step(self) -> str | End | None:
        """Take one step; return why the scenario has ended, or None. Raises Rejected."""
        with self.current():
            for watched, watch in self._temporal:
                with watched.bindings.restored(self.episode.state):
                    watch.step(self._scope_of(watched).truth)
                if watch.rest == FALSE:
                    raise Rejected(watched.label)
            if self._limit is not None and self._elapsed >= self._limit:
                return self.stop("reached time limit")
            self._elapsed += 1
            if self.compose is not None and self.compose.call.behavior.scenario.acts:
                step = self.compose.step()
                if isinstance(step, End) or self.compose.ended:
                    return self.stop(step if isinstance(step, End) else "finished compose block")
            label = self._condition_met("scenario")
            return None if label is None else self.stop(label)

    def _scope_of(self, watched: EpisodeStatement) -> Scope:
        return self.episode.scope(watched.scope)

    def _condition_met(self, extent: str) -> str | None:
        """Return the first `terminate when`, or `terminate simulation when`, that is true now."""
        for watched in self.kept["terminations"]:
            tree = watched.tree
            concerned = isinstance(tree, nodes.TerminateWhen) and tree.scope == extent
            try:
                if concerned and self._scope_of(watched).truth(tree.condition):
                    return watched.label
            except ScenicError as error:
                raise (error if self.compose is None else self.compose.seen_from_call(error)) from None
        return None

    def run_monitors(self) -> End | None:
        """Run all monitors of this scenario and of those inside it, even if one asks for an end: another might reject.

        Their `terminate` ends this scenario and with it the simulation, as in Scenic 3.1.1, wherever they belong;
        another end that was asked for here or inside is the reason that counts.
        """
        end: End | None = None
        own: End | None = None
        with self.current():
            for monitor in list(self._monitors):
                step = monitor.step()
                if isinstance(step, End) and step.scope == "simulation":
                    end = step
                elif isinstance(step, End):
                    own = step
        for sub in self._running():
            end = sub.run_monitors() or end
        if own is not None and self.running:
            self.stop(own)
        return end or own

    def simulation_ends(self) -> str | None:
        """Return the first `terminate simulation when` that is true, here or in a scenario inside."""
        with self.current():
            label = self._condition_met("simulation")
        return label or next((label for sub in self._running() if (label := sub.simulation_ends())), None)

    def stop(self, reason: str | End = "") -> str | End:
        """End the scenario and all inside it; gives the reason back. Raises Rejected if a requirement does not hold."""
        self.running = False
        if self.episode.program.dialect == 3:
            self._monitors = []  # those of Scenic 2 have their say in the step in which it ends
        if self.parent is not None:
            self.episode.records.update(self.own_records("final"))
        for sub in self._running():
            sub.stop()
        if self.compose is not None:
            self.compose.close()
        for (instance, name), value in self._overridden.items():
            instance.properties[name] = value
        self._overridden.clear()
        for watched, watch in self._temporal:
            if not watch.holds:
                raise Rejected(watched.label)
        return reason

    def end_by(self, end: End) -> End | None:
        """Heed a `terminate` in a behavior of one of its objects; return the end if it is that of the episode."""
        if end.scope == "scenario" and self.running:
            self.stop()
        return end if end.scope == "simulation" or self.parent is None else None

    def override(self, instance: Instance, values: dict[str, Value]) -> None:
        """Give an object other properties until this scenario ends."""
        for name, value in values.items():
            self._overridden.setdefault((instance, name), instance.properties[name])
            instance.properties[name] = value
        if values.get("behavior") is not None:
            self.agents.assign(instance)

    def own_records(self, when: str) -> Iterator[tuple[str, Value]]:
        """Yield the names and values of this scenario's `record` statements of one kind."""
        with self.current():
            for watched in self.kept["records"]:
                if watched.tree.when == when:
                    value = self._scope_of(watched).value(watched.tree.value)
                    yield watched.label, sampled(value, self.episode.row)

    def records(self) -> Iterator[tuple[str, Value]]:
        """Yield what `record` takes in every step, here and in scenarios inside."""
        yield from self.own_records("each")
        for sub in self._running():
            yield from sub.records()

    def _running(self) -> list[Scenario]:
        return [sub for sub in self.subs if sub.running]
