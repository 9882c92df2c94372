"""Does the regression test of the simulator detect a change of one constant, and does it tolerate other roundings?

Both checks run without Numba, on the changed source itself, so that a change needs no compiling. Records become plain
objects, which are a hundred times faster than NumPy's. `constants` multiplies one number of a law by 1.07 at a time, in
a separate process, and prints the first difference from the reference. `rounding` moves results by one unit in the last
place, up or down at random, except for 0 and 1. It applies to sine, cosine, exponential, logarithm, arc functions and
powers. This is more than processors and their libraries differ. It prints the rows that change:

    python -m lab.football_mutants constants --seed 1 --count 20
    python -m lab.football_mutants rounding --seed 1
"""

from __future__ import annotations

import argparse
import ast
import importlib.abc
import importlib.machinery
import json
import math
import os
import random
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

ROOT = Path(__file__).resolve().parents[1]
PACKAGE, FOOTBALL = "regista.envs.football", ROOT / "envs" / "football"
LAWS = ("physics", "skills", "ai", "rules", "control")
FACTOR, LEAST = 1.07, 1e-3  # for a constant; smaller constants only guard against zero
EXACT = (0.0, 1.0, -1.0, math.inf)  # results that every library returns exactly
ROUNDED = ("sin", "cos", "tan", "exp", "log", "atan2", "asin", "acos", "hypot")


class Site(NamedTuple):
    """A number in the source of a law: file, line, column, value."""

    file: str
    line: int
    column: int
    value: float


def sites() -> list[Site]:
    """Return all numbers of the laws that can change slightly: those with a decimal point that are not tiny."""
    files = [file for law in LAWS for file in sorted((FOOTBALL / law).glob("*.py"))]
    found = []
    for file in [*files, FOOTBALL / "constants.py"]:
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.Constant) and isinstance(node.value, float) and abs(node.value) >= LEAST:
                found.append(Site(str(file.relative_to(FOOTBALL)), node.lineno, node.col_offset, node.value))
    return found


# ---------------------------------------------------------------- changed sources


class Changed(importlib.abc.MetaPathFinder):
    """Provides the modules of the simulator with syntax trees transformed by `change`."""

    def __init__(self, change: Callable[[Path, ast.Module], ast.Module]) -> None:
        self.change = change

    def find_spec(self, name: str, path: Any, target: Any = None) -> importlib.machinery.ModuleSpec | None:
        """Return the module's own spec, with a loader that changes the module."""
        if not name.startswith(PACKAGE + "."):
            return None
        sys.meta_path.remove(self)
        try:
            spec = find_spec(name)
        finally:
            sys.meta_path.insert(0, self)
        if spec is not None and isinstance(spec.loader, importlib.machinery.SourceFileLoader):
            spec.loader = ChangedLoader(spec.loader.name, spec.loader.path)
            spec.loader.change = self.change
        return spec


class ChangedLoader(importlib.machinery.SourceFileLoader):
    """Compiles a module from a changed syntax tree."""

    change: Callable[[Path, ast.Module], ast.Module]

    def get_code(self, fullname: str) -> Any:
        """Return the code, without caching."""
        path = Path(self.path)
        tree = self.change(path.resolve(), ast.parse(path.read_text()))
        return compile(ast.fix_missing_locations(tree), self.path, "exec")


def with_constant(site: Site) -> Callable[[Path, ast.Module], ast.Module]:
    """Return a change of one number, as a function of path and tree."""

    def change(path: Path, tree: ast.Module) -> ast.Module:
        for node in ast.walk(tree) if path == FOOTBALL / site.file else ():
            if isinstance(node, ast.Constant) and (node.lineno, node.col_offset) == (site.line, site.column):
                node.value = FACTOR * site.value
        return tree

    return change


class Rounding(ast.NodeTransformer):
    """Passes the results of functions that libraries round differently to `rounded`."""

    def visit_Call(self, node: ast.Call) -> ast.AST:
        """Wrap calls of `math`."""
        self.generic_visit(node)
        called = node.func
        ours = isinstance(called, ast.Attribute) and isinstance(called.value, ast.Name) and called.value.id == "math"
        return wrapped(node) if ours and called.attr in ROUNDED else node  # type: ignore[attr-defined]

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        """Wrap powers."""
        self.generic_visit(node)
        return wrapped(node) if isinstance(node.op, ast.Pow) else node


def wrapped(node: ast.expr) -> ast.Call:
    """Return a call of `rounded` on an expression."""
    return ast.Call(ast.Name("rounded", ast.Load()), [node], [])


def round_otherwise(seed: int) -> Callable[[Path, ast.Module], ast.Module]:
    """Return a change that moves results by one unit in the last place."""
    rng = random.Random(seed)

    def rounded(value: Any) -> Any:
        if type(value) is not float or value in EXACT:
            return value
        return math.nextafter(value, math.inf if rng.random() < 0.5 else -math.inf)

    import builtins

    builtins.rounded = rounded  # type: ignore[attr-defined]
    return lambda path, tree: Rounding().visit(tree)


# ---------------------------------------------------------------- playing without arrays


def plain(record: Any, dtype: Any) -> SimpleNamespace:
    """Return a record as an object with the same fields: plain numbers, lists, and arrays with two axes."""
    thing = SimpleNamespace()
    for name in dtype.names:
        inner, value = dtype.fields[name][0], record[name]
        if inner.subdtype is not None and inner.subdtype[0].names:
            value = [plain(each, inner.subdtype[0]) for each in value]
        elif inner.names:
            value = plain(value, inner)
        elif inner.subdtype is not None:
            value = value.copy() if value.ndim > 1 or name == "checkpoint_reward" else value.tolist()
        elif name != "random":  # random states are shifted, and must wrap around
            value = value.item()
        setattr(thing, name, value)
    return thing


def moments(kept: Any, row: int) -> Iterator[tuple[list[int], list[float]]]:
    """Play a row of a scene as far as it is steady; yield facts and digests after each step, not observations."""
    import numpy as np

    from regista.envs.football.batch import cast_of
    from regista.envs.football.constants import BY_PROGRAM
    from regista.envs.football.control.episode import has_succeeded
    from regista.envs.football.control.reward import team_reward
    from regista.envs.football.simulator import step_match
    from regista.envs.football.state import MATCH
    from tests.envs.played import LEFT_COUNTS, make_env, weighted

    env, paid = make_env(kept.scene), 0.0
    batch, settings = env._batch, env._settings
    actions = kept.scene.actions(env.num_agents)[:, row].tolist()
    match = plain(np.asarray(batch.matches).view(MATCH)[row], MATCH)
    program: tuple[Any, ...] = (None, None, None, None)
    if settings.scripted:
        program = (env._engine._code, cast_of(settings), batch.registers[row], batch.commands[row])  # type: ignore[attr-defined]
    for step in range(int(kept.steady[row])):
        step_match(match, [BY_PROGRAM] * env.num_agents if env.scripted else actions[step], *program)
        paid += team_reward(match, settings.checkpoints)
        agents = sum(agent * (k * k + 1) for k, agent in enumerate(match.agents))
        facts = [match.game_mode, match.carrier, match.last_touch, match.reported_owner, *match.score]
        players = match.players[: match.num_players]
        places = [[match.ball.x, match.ball.y, match.ball.z], [*(p.x for p in players), *(p.y for p in players)]]
        digests = [float(weighted(np.array([numbers]))[0]) for numbers in places]
        cards = sum(player.cards + LEFT_COUNTS * player.has_left for player in match.players)
        facts += [cards, agents, match.ended]
        yield [*facts, int(has_succeeded(match, settings.defending))], [*digests, paid]


def first_change(kept: Any, row: int) -> tuple[int, str] | None:
    """Return the first step and quantity in which a row differs from the reference, None if there is no difference."""
    from tests.envs.played import DIGESTS, EVERY, FACTS, TOLERANCE

    for step, (facts, digests) in enumerate(moments(kept, row), 1):
        for name, was, now in zip(FACTS, kept.facts[step - 1, row].tolist(), facts, strict=True):
            if was != now:
                return step, name
        for k, now in zip((0, 1, 3), digests, strict=True) if step % EVERY == 0 else ():
            if not abs(kept.digests[step // EVERY - 1, row, k] - now) <= TOLERANCE:
                return step, DIGESTS[k]
    return None


def changes() -> Iterator[dict[str, Any]]:
    """Play the reference in this process, fast scenes first; yield each difference."""
    from tests.envs.played import load

    _, scenes = load()
    for kept in sorted(scenes, key=lambda kept: len(kept.scene.program) * (1 + 2 * ("behavior" in kept.scene.program))):
        for row in range(len(kept.steady)):
            if (change := first_change(kept, row)) is not None:
                yield {"scene": kept.scene.name, "row": row, "step": change[0], "what": change[1]}


# ---------------------------------------------------------------- the command


def notice(words: Sequence[str], only_first: bool) -> list[dict[str, Any]]:
    """Return the differences found by a separate process that plays a changed simulator."""
    command = [sys.executable, "-W", "ignore", "-m", "lab.football_mutants", *words]
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1", "OMP_NUM_THREADS": "1"}
    found = []
    with subprocess.Popen(command, cwd=ROOT, env=environment, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        for line in process.stdout:
            found.append(json.loads(line))
            if only_first:
                process.terminate()
                break
    if process.returncode and not found:
        found.append({"scene": "all", "row": 0, "step": 0, "what": "an error"})
    return found


def try_constants(seed: int, count: int) -> int:
    """Change `count` constants, one at a time; print the first differences; return the number of undetected changes."""
    missed, drawn = 0, random.Random(seed).sample(sites(), count)
    for number, site in enumerate(drawn, 1):
        found = notice(["one", *map(str, site)], only_first=True)
        line = (FOOTBALL / site.file).read_text().splitlines()[site.line - 1].strip()
        told = "{scene}, row {row}, step {step}: {what}".format(**found[0]) if found else "NOT NOTICED"
        missed += not found
        print(f"{number}. {site.file}:{site.line}: {site.value:g} of `{line[:60]}`: {told}", flush=True)
    print(f"{count - missed} of {count} are noticed")
    return missed


def main(argv: Sequence[str]) -> int:
    """Run the script and return its exit code."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("what", choices=("constants", "rounding", "one", "rounded"))
    parser.add_argument("site", nargs="*")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=20)
    typed = parser.parse_args(argv)
    if typed.what == "constants":
        return int(try_constants(typed.seed, typed.count) > 0)
    if typed.what == "rounding":
        found = notice(["rounded", "--seed", str(typed.seed)], only_first=False)
        print(*map(json.dumps, found), f"{len(found)} rows change", sep="\n")
        return 0
    site = typed.site
    change = (
        with_constant(Site(site[0], int(site[1]), int(site[2]), float(site[3])))
        if typed.what == "one"
        else round_otherwise(typed.seed)
    )
    sys.meta_path.insert(0, Changed(change))
    for found in changes():
        print(json.dumps(found), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
