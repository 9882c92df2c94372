"""Load a program: parse it, walk its tree once, and hand what it made to `Program`.

The evaluation itself is spread over `frame`, `expressions`, `calls`, `statements` and `modules`. Read next: `frame`.
"""

from __future__ import annotations

from pathlib import Path

from scenic_lite.calls import CALLS, call
from scenic_lite.domain import Domain
from scenic_lite.errors import Place, ScenicError
from scenic_lite.expressions import EXPRESSIONS
from scenic_lite.frame import Frame, Session, Source
from scenic_lite.functions import BUILTINS
from scenic_lite.modules import IMPORTS, import_module, parsed, read, take_all, wants_default_model
from scenic_lite.program import Program
from scenic_lite.statements import STATEMENTS, unpack
from scenic_lite.values import Namespace

DIALECTS = (2, 3)


def load(source: str | Path, domain: Domain | None = None, dialect: int = 2) -> Program:
    """Read a Scenic program.

    A Path, or a str that names an existing file or ends in `.scenic`, is read; another str is program text. `dialect`
    is 2 (the thesis's Scenic 2) or 3 (Scenic 3 in two dimensions). Raises ScenicError, with a place in the text, for
    whatever is wrong with the program.
    """
    if dialect not in DIALECTS:
        raise ValueError(f"dialect must be one of {DIALECTS}, not {dialect!r}")
    text, file, folder = text_of(source)
    session = new_session(domain, dialect)
    tree, doubts = parsed(text, file, dialect)
    place = Source(file, tuple(text.splitlines()), folder, library=False)
    session.sources[file] = place
    frame = Frame(session, place, {})
    if domain is not None and domain.default_model and wants_default_model(tree, domain.library):
        take_all(frame, import_module(frame, domain.default_model))
    frame.run(tree.body)
    if session.ego is None and (dialect == 2 or needs_ego(session)):
        raise no_ego(session, place)
    session.warnings += remaining(doubts, session)
    return Program(session, place, text)


def remaining(doubts: tuple[ScenicError, ...], session: Session) -> list[ScenicError]:
    """The parser's doubts about properties that the evaluation, knowing the classes, has not settled."""
    warned = {warning.place for warning in session.warnings}
    return [
        doubt
        for doubt in doubts
        if doubt.place not in warned and not (doubt.place in session.declared and doubt.hint.startswith("did you mean"))
    ]


def no_ego(session: Session, source: Source) -> ScenicError:
    """The error for a program without an ego, at its first object."""
    own = (each.place for each in session.objects if each.place.file == source.file)
    where = next(own, Place(source.file, 1, 0, 1, 1))
    hint = "write ego = ... before one of its objects"
    return ScenicError("name", "the program sets no ego", where, hint=hint, source_line=source.line(where.line))


def text_of(source: str | Path) -> tuple[str, str, Path | None]:
    """Text, name to print, and folder of a source."""
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
