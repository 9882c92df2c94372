"""Load a program: parse it, walk its tree once, and pass the result to `Program`.

`core.scope` and the modules of `evaluation` contain the evaluation itself. Read next: `core.scope`.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from scenic_lite.core.state import LOAD, Handlers, LoadState, Mode
from scenic_lite.core.types import Behavior, BehaviorCall, Namespace, Source, near
from scenic_lite.core.world import Domain
from scenic_lite.errors import ScenicError, SourceSpan
from scenic_lite.evaluation.access import unpack
from scenic_lite.evaluation.calls import CALLS, call, scenario_frame
from scenic_lite.evaluation.expressions import EXPRESSIONS
from scenic_lite.evaluation.functions import BUILTINS
from scenic_lite.evaluation.modules import IMPORTS, read, run_file, source_of
from scenic_lite.evaluation.statements import STATEMENTS
from scenic_lite.language.requirements import apply_mutations
from scenic_lite.scene.program import Program
from scenic_lite.scene.pruning import prune
from scenic_lite.syntax.parser import dialect_of


def load(
    source: str | Path,
    domain: Domain | None = None,
    dialect: int | None = None,
    scenario: str | None = None,
    params: Mapping[str, object] | None = None,
    model: str | None = None,
) -> Program:
    """Read a Scenic program.

    `source` is a file if it is a Path, the name of an existing file, or a str that ends in `.scenic`. Any other str is
    program text.

    `dialect` is 2 (the thesis's Scenic 2) or 3 (Scenic 3 in two dimensions). By default, a first line `# scenic: 2` or
    `# scenic: 3` determines it. Without such a line, a program that creates objects with `new` has dialect 3, any
    other program dialect 2. `scenario` names the modular scenario to run; the default is `Main`, or the only scenario.
    `params` are global parameters that override those of the program. `model` names a module that replaces the
    program's own `model` statement or the domain's default model.

    Raises:
        ScenicError: any error in the program, with its place in the text.
        ValueError: an argument with an invalid value.
        TypeError: an argument of an invalid type.
    """
    text, file, folder = text_of(source)
    mode = load_mode(domain, dialect_of(text, file, dialect))
    state = mode.state
    override(state, file, params or {}, model)
    state.root = folder
    own = source_of(text, file, folder)
    run_file(mode, text, own)
    set_up_main(mode, own, scenario)
    warn_of_overrides(state, own)
    apply_mutations(state)
    refuse_without_ego(state, own)
    prune(state)
    warnings = {(slip.place, slip.message): slip for slip in state.warnings + state.diagnostics}  # without duplicates
    return Program(mode, own, text, tuple(warnings.values()))


def set_up_main(mode: Mode, source: Source, name: str | None) -> None:
    """Run the setup of the main scenario, if there is one. Raises ScenicError if it is ambiguous."""
    state = mode.state
    scenario = main_of(state, source, name)
    if scenario is None:
        return
    place = scenario.scope.place(scenario.node)
    try:
        arguments = scenario.bind([], {})
    except ScenicError as error:
        error.hint = "the scenario that a program is gets no arguments: give its parameters defaults"
        raise scenario.scope.placed(error, scenario.node) from None
    state.main = BehaviorCall(scenario, arguments, place)
    scope = state.main_frame = scenario_frame(mode, state.main)
    state.monitors, state.terminations, state.records = [], [], []
    scope.run(scenario.scenario.setup)


def main_of(state: LoadState, source: Source, name: str | None) -> Behavior | None:
    """Return the main scenario of the program's own file, if it has one."""
    known = {scenario.name: scenario for scenario in state.scenarios if scenario.scope.source is source}
    if name is not None:
        if name not in known:
            raise ScenicError("name", f"{source.file} has no scenario '{name}'", hint=near(name, known))
        return known[name]
    if "Main" in known:
        return known["Main"]
    if len(known) > 1:
        hint = 'call the one to run "Main", or say which one it is'
        message = f"there are several scenarios: {', '.join(known)}"
        raise ScenicError("value", message, source.start, hint=hint, source_line=source.line(1))
    only = next(iter(known.values()), None)
    return only if only is not None and not only.required() else None


def override(state: LoadState, file: str, params: Mapping[str, object], model: str | None) -> None:
    """Set the caller's parameters and model, which the program cannot change."""
    if not isinstance(params, Mapping):
        raise TypeError(f"params must map names to values, got {type(params).__name__}")
    for name, value in params.items():
        if not isinstance(name, str):
            raise TypeError(f"the name of a parameter must be a text, got {name!r}")
        if not is_plain(value):
            raise TypeError(f"the parameter '{name}' must be a number, a text, a truth value, None, or a list of them")
        state.params[name] = value
        state.param_places[name] = SourceSpan(file, 1, 0, 1, 1)
    state.fixed_params = frozenset(params)
    if model is not None and not isinstance(model, str):
        raise TypeError(f"model must be the name of a module, got {model!r}")
    state.model = model


def is_plain(value: object) -> bool:
    """Return whether a program could contain the value as a literal."""
    if isinstance(value, list | tuple):
        return all(is_plain(part) for part in value)
    if isinstance(value, dict):
        return all(is_plain(part) for pair in value.items() for part in pair)
    return value is None or type(value) in (bool, int, float, str)


def warn_of_overrides(state: LoadState, own: Source) -> None:
    """Warn about a caller's parameter that the program never sets but whose name resembles a parameter that it sets."""
    unset = own.start
    known = {name for name, place in state.param_places.items() if place != unset}
    known |= state.domain.params if state.domain else frozenset()
    for name in sorted(state.fixed_params - known):
        hint = near(name, known)
        if hint:
            message = f"the program sets no parameter '{name}', which its caller overrides"
            state.warnings.append(ScenicError("warning", message, unset, hint=hint, source_line=own.line(1)))


def refuse_without_ego(state: LoadState, source: Source) -> None:
    """Raise ScenicError, at the first object, if the program needs an ego and sets none.

    Dialect 3 needs an ego only for visibility. Dialect 2 always needs one, except in a scenario with a compose block.
    """
    if state.dialect == 2:
        needed = state.main is None or not state.main.behavior.scenario.compose
    else:
        needed = any(instance.properties["requireVisible"] is True for instance in state.objects)
    if state.ego is not None or not needed:
        return
    own = (instance.place for instance in state.objects if instance.place.file == source.file)
    with state.with_location(next(own, source.start)):
        raise ScenicError("name", "the program sets no ego", hint="write ego = ... before one of its objects")


def text_of(source: str | Path) -> tuple[str, str, Path | None]:
    """Return the text, the displayed name and the folder of a source."""
    if not isinstance(source, str | Path):
        raise TypeError(f"load takes the path or the text of a program, not {type(source).__name__}")
    if isinstance(source, Path) or source.endswith(".scenic") or is_file(source):
        path = Path(source)
        return read(path), path.name, path.parent
    return source, "<program>", None


def is_file(source: str) -> bool:
    if "\n" in source or len(source) > 1000:
        return False
    try:
        return Path(source).is_file()
    except (OSError, ValueError):
        return False


def load_mode(domain: Domain | None, dialect: int) -> Mode:
    """Return the initial mode of a load, with only the names of the language."""
    state = LoadState(domain, dialect)
    builtins = BUILTINS | {"globalParameters": Namespace("globalParameters", state.params)}
    handlers = Handlers(EXPRESSIONS | CALLS, STATEMENTS | IMPORTS, builtins, call, unpack)
    return Mode(LOAD, state, handlers, state.budget, state.column)
