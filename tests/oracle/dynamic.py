"""Dynamic programs: play episodes in the toy simulator and count what happens in them.

Fields as the oracle has them: `sims`, `steps`, `rejected`, `endings`, `lengths`; `traces`, the actions of every agent
at every step with how often they occurred; `records`, `per_step`. Read next: `envs/toy_world.py`.
"""

import collections
import json
from dataclasses import replace
from pathlib import Path

import numpy as np

from regista.envs.toy_world import properties, toy_world
from scenic_lite import Domain, Program, load
from scenic_lite.core.types import Instance
from scenic_lite.values.geometry import Vector
from tests.reference.interpreter import Reference
from tests.scenic_lite.dynamics.toy_world import Trace, first_table, run

MOST_TRACES, MOST_RECORDS, MOST_PER_STEP = 30, 5, 20


def dynamic(path: Path, entries: dict[str, str], world: Domain, dialect: int) -> dict:
    """Return the record's fields for a program of kind `dynamic`. Raises ScenicError if it is none."""
    program = load(path, world, dialect)
    count, steps = int(entries["sims"]), int(entries["steps"])
    theta, _ = program.sample(count, np.random.default_rng(7))
    endings, lengths, traces, records = (collections.Counter() for _ in range(4))
    rejected = 0
    for i in range(count):
        reference, trace = play(program, theta[i], entries, i)
        if trace.rejected:
            rejected += 1
            continue
        endings[trace.ending] += 1
        lengths[len(trace.commands)] += 1
        traces[json.dumps(written(trace))] += 1
        records[json.dumps({name: plain_record(value) for name, value in reference.records.items()})] += 1
    fields = {"sims": count, "steps": steps, "rejected": rejected, "endings": dict(endings)}
    fields["lengths"] = {str(key): value for key, value in lengths.items()}
    fields["traces"] = [{"count": n, "trace": json.loads(text)} for text, n in traces.most_common(MOST_TRACES)]
    fields["distinct_traces"] = len(traces)
    if set(records) != {"{}"}:
        fields["records"] = [{"count": n, "records": json.loads(text)} for text, n in records.most_common(MOST_RECORDS)]
    return fields | ({"per_step": by_step(traces)} if count > 1 else {})


def play(program: Program, theta: np.ndarray, entries: dict[str, str], seed: int) -> tuple[Reference, Trace]:
    """Play one episode as a header says."""
    world = toy_world(float(entries.get("timestep", 1)))
    reference = Reference(program, theta, replace(world, properties=as_written), seed)
    drift = float(entries.get("drift", 0))
    return reference, run(first_table(program, theta), reference, int(entries.get("steps", 3)), drift)


def as_written(instance: Instance, fields: dict) -> dict:
    """Return live properties with heights as the program's integers while they are true: texts show the difference."""
    live = properties(instance, fields)
    before, now = instance.properties["position"], live["position"]
    same = isinstance(before.y, int) and before.y == now.y
    return live | {"position": Vector(now.x, before.y if same else now.y)}


def written(trace: Trace) -> list[dict[str, list[str]]]:
    """Return the actions of every agent at every step, as texts."""
    return [{f"o{i}": [text(a) for a in step.actions[i]] for i in step.agents} for step in trace.commands]


def text(action: object) -> str:
    """Return a value as Scenic's `str`: objects of programs have no names there."""
    if isinstance(action, Vector):
        return f"({action.x}, {action.y}, 0.0)"
    return f"unnamed {action.cls.name}2D" if isinstance(action, Instance) else str(action)


def by_step(traces: collections.Counter) -> dict[str, dict[str, int]]:
    """Return how often each joint action occurred at each step."""
    steps: dict[int, collections.Counter] = collections.defaultdict(collections.Counter)
    for trace, count in traces.items():
        for i, step in enumerate(json.loads(trace)):
            steps[i][json.dumps(step, sort_keys=True)] += count
    return {str(i): dict(counter.most_common(MOST_PER_STEP)) for i, counter in steps.items()}


def plain_record(value: object) -> object:
    """Return a record in JSON: a series of [time, value], or one value."""
    if isinstance(value, list):
        return [[time, plain(each)] for time, each in value]
    return plain(value)


def plain(value: object) -> object:
    if isinstance(value, bool | str | None):
        return value
    return float(value) if isinstance(value, int | float) else None
