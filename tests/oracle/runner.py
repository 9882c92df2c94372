"""Run the programs of a folder through our interpreter: one record for each, in the shape of the oracle's files.

Read next: `static` and `errors`, the kinds of programs; a module for another kind adds itself to `KINDS`.
"""

import signal
import sys
import time
from contextlib import contextmanager
from pathlib import Path

from scenic_lite import Domain, ScenicError
from tests.oracle.dynamic import dynamic
from tests.oracle.errors import error_record, failing
from tests.oracle.static import static

SECONDS = 60  # for one program
KINDS = {
    "static": static,
    "error": failing,
    "dynamic": dynamic,
}  # kind -> (path, header, world, dialect) -> fields of the record, or None


class OutOfTime(Exception):
    """A program that takes longer than `SECONDS`."""


def header(path: Path) -> dict[str, str]:
    """Return the `#! key: value; key: value` lines at the start of a program."""
    entries: dict[str, str] = {}
    for line in path.read_text().splitlines():
        if not line.startswith("#!"):
            break
        for part in line[2:].split(";"):
            key, _, value = part.partition(":")
            entries[key.strip()] = value.strip()
    return entries


def world_of(folder: Path) -> Domain:
    """Return the modules that a folder's programs may import beside neighbors: those of `lib` in it or beside it."""
    libraries = (folder.resolve().parent / "lib", folder.resolve() / "lib")
    return Domain("oracle", {path.stem: path for library in libraries for path in sorted(library.glob("*.scenic"))})


def programs_of(folder: Path, only: str = "") -> list[Path]:
    """Return the programs of a folder whose names contain `only`."""
    return [path for path in sorted(folder.glob("*.scenic")) if only in path.name and "kind" in header(path)]


def run_folder(folder: Path, dialect: int, only: str = "") -> dict[str, dict]:
    """Return a record for each program, by its name; one that we cannot run yet is named on stderr."""
    world, records = world_of(folder), {}
    for path in programs_of(folder, only):
        start = time.perf_counter()
        record = run_program(path, dialect, world)
        if record is None:
            print(f"{path.stem}: not run, programs of this kind are not supported yet", file=sys.stderr)
            continue
        records[path.stem] = record
        fault = record.get("error", {})
        crashed = f" {fault['type']}: {fault['message']}" if fault.get("stage") in ("crash", "time") else ""
        print(f"{path.stem}: {time.perf_counter() - start:.1f} s{crashed}", file=sys.stderr)
    return records


def run_program(path: Path, dialect: int, world: Domain) -> dict | None:
    """Return the record of one program, whatever happens; None for a kind that we do not run."""
    entries = header(path)
    record = {"id": entries.get("id", path.stem), "kind": entries["kind"]}
    run = KINDS.get(entries["kind"])
    if run is None:
        return None
    try:
        with deadline(SECONDS):
            fields = run(path, entries, world, dialect)
    except ScenicError as error:
        fields = {"error": error_record(error, "sample" if error.kind == "rejection" else "compile")}
    except OutOfTime as fault:
        fields = {"error": {"stage": "time", "type": "OutOfTime", "bases": [], "message": str(fault)}}
    except Exception as fault:  # an error of ours: the other programs are run all the same
        fields = {"error": {"stage": "crash", "type": type(fault).__name__, "bases": [], "message": str(fault)}}
    return None if fields is None else record | fields


@contextmanager
def deadline(seconds: int):
    """Raise OutOfTime inside after so many seconds."""

    def stop(_signal, _frame):
        raise OutOfTime(f"takes more than {seconds} seconds")

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
