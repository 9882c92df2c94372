"""Load a program: parse it, walk its tree once, and hand what it made to `Program`.

The evaluation itself is spread over `frame`, `expressions`, `calls`, `statements` and `modules`. Read next: `frame`.
"""

from __future__ import annotations

from pathlib import Path

from scenic_lite.assignments import unpack
from scenic_lite.calls import CALLS, call
from scenic_lite.domain import Domain
from scenic_lite.errors import Place, ScenicError
from scenic_lite.expressions import EXPRESSIONS
from scenic_lite.frame import Session, Source
from scenic_lite.functions import BUILTINS
from scenic_lite.modular import set_up_main
from scenic_lite.modules import IMPORTS, read, run_file, source_of
from scenic_lite.program import Program
from scenic_lite.requirements import settle
from scenic_lite.statements import STATEMENTS
from scenic_lite.values import Namespace

DIALECTS = (2, 3)


def load(
    source: str | Path, domain: Domain | None = None, dialect: int = 2, scenario: str | None = None
) -> Program:
    """Read a Scenic program.

    A Path, or a str that names an existing file or ends in `.scenic`, is read; another str is program text. `dialect`
    is 2 (the thesis's Scenic 2) or 3 (Scenic 3 in two dimensions). `scenario` names the modular scenario to run; without
    it, that is `Main`, or the only one. Raises ScenicError, with a place in the text, for
    whatever is wrong with the program.
    """
    if dialect not in DIALECTS:
        raise ValueError(f"dialect must be one of {DIALECTS}, not {dialect!r}")
    text, file, folder = text_of(source)
    session = new_session(domain, dialect)
    own = source_of(text, file, folder)
    run_file(session, text, own)
    set_up_main(session, own, scenario)
    settle(session)
    if session.ego is None and (dialect == 2 or needs_ego(session)):
        raise no_ego(session, own)
    return Program(session, own, text, warnings_of(session))


def warnings_of(session: Session) -> tuple[ScenicError, ...]:
    """What the evaluation warns of, and the doubts that it, knowing the classes, has not settled; once each."""
    warnings = {(warning.place, warning.message): warning for warning in session.warnings}
    warned = {place for place, _ in warnings}
    for doubt in session.doubts:
        settled = doubt.place in session.declared and doubt.hint.startswith("did you mean")
        if doubt.place not in warned and not settled:
            warnings[doubt.place, doubt.message] = doubt
    return tuple(warnings.values())


def no_ego(session: Session, source: Source) -> ScenicError:
    """The error for a program without an ego, at its first object."""
    own = (each.place for each in session.objects if each.place.file == source.file)
    where = next(own, Place(source.file, 1, 0, 1, 1))
    hint = "write ego = ... before one of its objects"
    return ScenicError("name", "the program sets no ego", where, hint=hint, source_line=source.line(where.line))


def text_of(source: str | Path) -> tuple[str, str, Path | None]:
    """Text, name to print, and folder of a source."""
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


def new_session(domain: Domain | None, dialect: int) -> Session:
    """A session that knows all of the language and nothing yet of a program."""
    params: dict = {}
    builtins = BUILTINS | {"globalParameters": Namespace("globalParameters", params)}
    session = Session(domain, dialect, EXPRESSIONS | CALLS, STATEMENTS | IMPORTS, builtins, call, unpack)
    session.params = params
    return session


def needs_ego(session: Session) -> bool:
    """Dialect 3 needs an ego only to see others."""
    return any(each.properties["requireVisible"] is True for each in session.objects)
