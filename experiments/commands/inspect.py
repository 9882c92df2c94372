"""`regista inspect`: show a program: its free parameters, requirements, scenes, tokens, syntax tree or code.

    regista inspect 1v1Free
    regista inspect mine.scenic --show nodes
    regista inspect 1v1Free --png scenes.png --n 12 --seed 3
    regista inspect mine.scenic --engine scenic3            # interpreted by Scenic 3
    regista inspect mine.scenic --rrd scenes.rrd
    regista inspect --adversary runs/paired                 # proposals of a run's adversary, by parameter

Read next: `scenic_lite.scene.program`, the program; `pictures.scene_view`, which draws scenes.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from regista.experiments.pictures.plots import FORMAT_HELP, PictureFormat, in_format
from regista.experiments.run import arguments, build
from regista.experiments.run.arguments import group, positional
from regista.experiments.run.config import ProgramConfig
from regista.experiments.run.errors import CommandError, UsageError
from regista.experiments.run.games import single_game
from regista.experiments.run.notes import warn
from regista.experiments.run.programs import load_any_program, read_params, warn_of_play
from regista.experiments.run.results import align
from regista.experiments.run.tasks import PythonTask
from ued.config import LARGEST_SEED, Checked, setting

if TYPE_CHECKING:
    from scenic_lite import Program

DESCRIPTION = "Show a program: its free parameters θ, its objects, its acceptance rate and scenes."
DRAWS = 4096  # samples for the acceptance rate
INDENT = "  "
MOST_DRAWN = 100  # scenes in a picture; more scenes would make the picture too large for its file


@dataclass(frozen=True)
class InspectConfig(Checked):
    """Arguments of `regista inspect`."""

    program: str = positional("minigame, .scenic program, or Python task file.py:name", default="")
    show: Literal["theta", "scenes", "tokens", "nodes", "code"] = setting(
        "theta",
        "theta: parameters, objects, acceptance; scenes: positions in sampled scenes; tokens, nodes: syntax; "
        "code: compiled behaviors",
    )
    png: Path | None = setting(None, "draw --n scenes to this picture, such as scenes.png or scenes.pdf")
    format: PictureFormat | None = setting(None, f"{FORMAT_HELP} (default: the ending of the file, or png)")
    rrd: Path | None = setting(None, "record --n scenes to this Rerun file")
    n: int = setting(6, "number of scenes to draw, record or print", ">=1", most=10_000)
    seed: int = setting(0, "seed of the scenes", most=LARGEST_SEED, least=0)
    theta: tuple[float, ...] = setting((), "use this θ in [-1, 1]^D instead of random ones", most=1, least=-1)
    dialect: int | None = setting(None, "Scenic version of the program, 2 or 3 (default: detected)", most=3, least=2)
    engine: Literal["regista", "scenic3"] = setting("regista", "interpreter: regista, or scenic3 for Scenic 3 itself")
    mode_2d: bool = setting(False, "with scenic3: use its 2D compatibility mode, which the driving domain requires")
    adversary: Path | None = setting(
        None, "instead of a program: a run folder; print its adversary's proposals next to the program's distribution"
    )
    reading: ProgramConfig = group(ProgramConfig, "the program")


def main(argv: Sequence[str]) -> int:
    """Run the command and return its exit code."""
    config = arguments.parse(InspectConfig(), argv, "inspect", DESCRIPTION)
    if config.png is not None:
        try:
            config = replace(config, png=in_format(config.png, config.format))
        except ValueError as error:
            raise UsageError(str(error)) from error
        if config.n > MOST_DRAWN and not config.theta:
            raise UsageError(f"--png draws at most {MOST_DRAWN} scenes, got --n {config.n}; --rrd records more")
    elif config.format is not None:
        raise UsageError("--format is of the picture that --png draws")
    if config.adversary is not None:
        return inspect_adversary(config.adversary, config)
    if not config.program:
        raise UsageError("inspect needs a program: a minigame's name or the path of a .scenic file")
    game = build.find_game(config.program)
    if isinstance(game, PythonTask):
        return inspect_task(game, config)
    if config.dialect not in (None, 2, 3):
        raise UsageError(f"--dialect must be 2 or 3, got {config.dialect}")
    path = single_game(config.program).minigame.program
    if config.engine == "scenic3":
        return inspect_scenic3(path, config)
    if config.show in ("tokens", "nodes"):
        print_text(path, config)
        return 0
    program, football = load_any_program(path, config.dialect, config.reading)
    if football and config.show != "code":
        warn_of_play(program)
    if config.show == "code":
        print(render_code(program, football))
    elif config.show == "scenes":
        print(render_scenes(program, choose_theta(program, config)))
    else:
        print(render_theta(program, choose_theta(program, config) if config.theta else None))
    if config.png is not None or config.rrd is not None:
        write_scenes(program, football, config)
    return 0


def write_scenes(program: Program, football: bool, config: InspectConfig) -> None:
    """Draw scenes of a program to `--png`, and record them in `--rrd`."""
    theta = choose_theta(program, config)
    plural = "s" * (len(theta) > 1)
    if config.png is not None:
        draw_scenes(program, theta, config.png, football)
        print(f"\n{len(theta)} scene{plural} drawn to {config.png}")
    if config.rrd is not None:
        write_recording(program, theta, config.rrd, football)
        print(f"\n{len(theta)} scene{plural} recorded in {config.rrd}; open it with: rerun {config.rrd}")


def inspect_adversary(folder: Path, config: InspectConfig) -> int:
    """Print the proposals of a run's adversary, and draw them with `--png`."""
    from regista.experiments.run import proposals
    from regista.experiments.run.folder import RunFolder

    run = RunFolder.open(folder)
    if config.program:
        raise UsageError("inspect takes a program or --adversary RUN, not both")
    task = build.find_game(run.config.minigame).task(run.config)
    with closing(build.make_upomdp(task.make, 1, 0)) as upomdp:
        columns = proposals.read_proposals(folder, upomdp.parameters)
    print(proposals.render_proposals(folder, columns))
    if config.png is not None:
        from regista.experiments.pictures.level_plots import draw_proposals

        draw_proposals(columns, config.png)
        print(f"\nproposals drawn to {config.png}")
    return 0


def inspect_task(game: PythonTask, config: InspectConfig) -> int:
    """Show a Python task: its parameters, random levels or the given one, and their first frames."""
    if config.engine == "scenic3":
        raise UsageError("--engine applies to programs; a task is Python code")
    if config.rrd is not None or config.show != "theta":
        raise UsageError("--rrd and --show are for Scenic programs; --png draws levels of a Python task")
    from regista.experiments.pictures.task_view import describe_task, draw_task
    from regista.experiments.run.evaluator import theta_of_test
    from ued.core.level_space import check_theta

    task = game.task(None)
    upomdp = build.make_upomdp(task.make, 1 if config.theta else config.n, config.seed)
    theta = check_theta(config.theta, upomdp.theta_dim) if config.theta else upomdp.levels["theta"].copy()
    for label, scene in (task.scenes() | task.scenes(held_out=True)).items():
        theta_of_test(label, scene, upomdp, game.name)
    print(describe_task(config.program, upomdp, theta))
    if config.png is not None:
        draw_task(upomdp, theta, config.png, markers=task.painter(upomdp).markers if task.painter else ())
        print(f"\n{len(theta)} level{'s' * (len(theta) > 1)} drawn to {config.png}")
    upomdp.close()
    return 0


def inspect_scenic3(path: Path, config: InspectConfig) -> int:
    """Show a program as interpreted by Scenic itself."""
    if config.show not in ("theta", "scenes") or config.png is not None or config.rrd is not None:
        raise UsageError("with --engine scenic3, inspect supports --show theta and scenes, without pictures")
    try:
        from regista.envs.scenic3 import ScenicProgram

        reading = config.reading
        program: Any = ScenicProgram(path, read_params(reading.param), reading.scenario, reading.model, config.mode_2d)
    except ImportError as error:
        raise CommandError(str(error)) from error
    except Exception as error:  # a program can run any Python code
        raise CommandError(f"{path}: Scenic rejects it: {type(error).__name__}: {error}") from error
    if config.show == "scenes":
        print(render_scenes(program, choose_theta(program, config)))
        return 0
    print(render_theta(program, choose_theta(program, config) if config.theta else None, DRAWS // 8))
    if program.by_seed:
        print(f"\nsampled from the level's seed: {', '.join(program.by_seed)}")
    return 0


def choose_theta(program: Program, config: InspectConfig) -> np.ndarray:
    """Return the given θ, or valid random ones: `[n, D]`."""
    if not config.theta:
        return program.sample_theta(config.n, np.random.default_rng(config.seed))
    theta = np.array(config.theta)
    if len(theta) != program.dim or np.abs(theta).max() > 1:
        raise UsageError(
            f"--theta takes {program.dim} numbers in [-1, 1] for {program.file}, got {_join(config.theta)}"
        )
    return theta[None]


# ---------------------------------------------------------------- θ, objects, acceptance


def render_theta(program: Program, theta: np.ndarray | None, draws: int = DRAWS) -> str:
    """Return the parameters of a program as a table, its objects, its settings and its acceptance rate."""
    parts = [f"{program.file}: D = {program.dim} free parameter{'s' * (program.dim != 1)}"]
    if program.draws:
        parts.append(_draws_table(program, theta))
    parts += [_objects_table(program), str(program.report(draws, np.random.default_rng(0)))]
    if theta is not None:
        parts.append("this θ describes " + ("a valid scene" if program.valid(theta)[0] else "no valid scene"))
    return "\n\n".join(parts)


def _draws_table(program: Program, theta: np.ndarray | None) -> str:
    rows = [["θ", "name", "kind", "from", "to", "line"]]
    values = None if theta is None else program.describe(theta[0])
    if values is not None:
        rows[0] += ["θ value", "value"]
    for column, draw in enumerate(program.draws):
        kind: Any = draw.kind
        label = kind if isinstance(kind, str) else type(kind).__name__.lower()
        row = [str(column), draw.name, label, _number(draw.low), _number(draw.high), _line(program, draw.place)]
        if theta is not None and values is not None:
            row += [f"{theta[0, column]:+.2f}", _number(values[draw.name])]
        rows.append(row)
    return align(rows)


def _objects_table(program: Program) -> str:
    rows = [["object", "class", "behavior", "line"]]
    for index, info in enumerate(program.objects):
        name = info.name or ("ego" if index == 0 else "")
        rows.append([name, info.class_name, info.behavior or "", _line(program, info.place)])
    return align(rows)


def _line(program: Program, place: Any) -> str:
    return str(place.line) if place.file == program.file else f"{Path(place.file).name}:{place.line}"


def _number(value: Any) -> str:
    if not isinstance(value, int | float):
        return str(value)
    return "varies" if np.isnan(value) else f"{value:g}"


def _join(values: Sequence[float]) -> str:
    return " ".join(f"{value:g}" for value in values)


# ---------------------------------------------------------------- scenes


def render_scenes(program: Program, theta: np.ndarray) -> str:
    """Return the positions of all objects in the scenes of θ `[N, D]`, in the program's coordinates."""
    scenes = program.instantiate(theta)
    parts = []
    for index in range(len(theta)):
        rows = [["object", "class", "x", "y", "heading"]]
        for k, info in enumerate(program.objects):
            x, y = scenes.positions[index, k]
            rows.append(
                [info.name, info.class_name, f"{x:.2f}", f"{y:.2f}", f"{np.degrees(scenes.headings[index, k]):.0f}°"]
            )
        validity = "" if scenes.ok[index] else "   (not valid)"
        parts.append(f"scene {index}: θ = {_join(theta[index])}{validity}\n{align(rows)}")
    return "\n\n".join(parts)


def draw_scenes(program: Program, theta: np.ndarray, path: Path, football: bool) -> None:
    """Draw the scenes of θ `[N, D]`: a match on its pitch, any other program on its workspace."""
    from regista.envs.football.scenic.lineup import Lineup, NotAMatchError
    from regista.envs.football.view.render import FootballPainter
    from regista.experiments.pictures.scene_pictures import draw_matches, draw_pictures
    from regista.experiments.pictures.scene_view import view_of

    if football:
        try:
            return draw_matches(FootballPainter(Lineup(program)), theta, path)
        except NotAMatchError:  # football without a ball, or with other objects on the pitch
            pass
    view = view_of(program, probes(program, theta), football)
    draw_pictures(view, program.instantiate(theta), path)


def write_recording(program: Program, theta: np.ndarray, path: Path, football: bool) -> None:
    """Record the scenes of θ `[N, D]` for the Rerun viewer. Raises `CommandError` if the file cannot be written."""
    from regista.experiments.pictures.scene_recording import SceneRecord, record_scenes
    from regista.experiments.pictures.scene_view import arrows, corners, view_of
    from regista.experiments.run.table import cannot_write

    view = view_of(program, probes(program, theta), football)
    boxes = view.boxes(program.instantiate(theta))
    cards = [card(program, theta[index], index) for index in range(len(theta))]
    scenes = [SceneRecord(*parts) for parts in zip(corners(boxes), arrows(boxes), cards, strict=True)]
    try:
        record_scenes(path, program.file, view, scenes)
    except OSError as error:
        raise cannot_write(path, error) from error


def probes(program: Program, theta: np.ndarray) -> np.ndarray:
    """Return θ and additional random rows, to estimate the extent of the scene."""
    from regista.experiments.pictures.scene_view import PROBES

    return np.vstack([theta, np.random.default_rng(0).uniform(-1, 1, (PROBES, program.dim))])


def card(program: Program, theta: np.ndarray, index: int) -> str:
    """Return the values of one row of θ, in Markdown."""
    from regista.experiments.pictures.scene_recording import card_of

    values = program.describe(theta)
    rows = [(name, f"{at:+.3f}", _number(value)) for at, (name, value) in zip(theta, values.items(), strict=True)]
    scene = program.instantiate(theta[None])
    broken = [rule.label for rule, failed in zip(program.requirements, scene.failed[0], strict=True) if failed]
    notes = [f"not valid: {', '.join(broken) or 'a position is not a number'}"] if not scene.ok[0] else []
    return card_of(f"{program.file}, scene {index}", rows, notes)


# ---------------------------------------------------------------- code


def render_code(program: Program, football: bool) -> str:
    """Return the compiled rows of behaviors, monitors and conditions, each below its source line."""
    from regista.envs.football.scenic.world import FOOTBALL_WORLD
    from regista.envs.toy_world import toy_world
    from scenic_lite.dynamics.compiler.compile import compile_program

    compiled = compile_program(program, FOOTBALL_WORLD if football else toy_world())
    for warning in compiled.warnings:
        warn(f"warning: {warning}")
    counts = f"{len(compiled.code.rows)} rows, {compiled.code.register_count} numbers for each match"
    return f"{program.file}: {counts}\n\n{compiled.disassembly()}"


# ---------------------------------------------------------------- text


def print_text(path: Path, config: InspectConfig) -> None:
    """Print the tokens or the tree of a program's text."""
    from scenic_lite.syntax.lexer import Source, lex
    from scenic_lite.syntax.parser import dialect_of, parse

    text = path.read_text()
    if config.show == "tokens":
        for token in lex(Source(text, str(path))):
            place = f"{token.line}:{token.column + 1}"
            print(f"{place:<8}{token.kind:<10}{token.text!r}")
        return
    for line in render_node(parse(text, str(path), dialect_of(text, str(path), config.dialect)), 0):
        print(line)


def render_node(node: Any, depth: int, label: str = "") -> Iterator[str]:
    """Return a tree as indented lines: the class of each node, its plain fields, its line."""
    simple, nested = [], []
    for name, value in ast.iter_fields(node):
        if isinstance(value, ast.AST) or (isinstance(value, list) and any(isinstance(v, ast.AST) for v in value)):
            nested.append((name, value))
        elif value not in (None, []):
            simple.append(f"{name}={value!r}")
    place = f"   line {node.lineno}" if isinstance(node, ast.stmt) else ""
    prefix = f"{label}: " if label else ""
    yield f"{INDENT * depth}{prefix}{type(node).__name__} {' '.join(simple)}".rstrip() + place
    for name, value in nested:
        if isinstance(value, ast.AST):
            if not isinstance(value, ast.expr_context):
                yield from render_node(value, depth + 1, name)
            continue
        for item in value:
            if isinstance(item, ast.AST):
                yield from render_node(item, depth + 1, name)
            else:
                yield f"{INDENT * (depth + 1)}{name}: {item!r}"
