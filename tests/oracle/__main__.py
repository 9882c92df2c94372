"""The oracle from the command line: run a folder, compare two files of records, merge new expectations.

Read next: `runner`.
"""

import argparse
import json
import sys
from pathlib import Path

from tests.oracle.compare import differences
from tests.oracle.runner import run_folder

# What the comparison reads, of a record, of a description and of an error.
RECORD = ("id", "kind", "n", "objects", "values", "corr", "rel", "error", "no_error")
DYNAMIC = ("sims", "rejected", "endings", "lengths", "traces", "records", "per_step")
ERROR = ("stage", "type", "bases", "message", "line", "column")


def main(arguments: list[str]) -> int:
    """Carry out one command; returns the exit status."""
    if arguments and arguments[0] not in ("run", "compare", "merge", "-h", "--help"):
        arguments = ["run", *arguments]
    parser = argparse.ArgumentParser(prog="python -m tests.oracle", description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(dest="command", required=True)
    run = commands.add_parser("run", help="run the programs of a folder")
    run.add_argument("folder", type=Path)
    run.add_argument("--dialect", type=int, choices=(2, 3), default=3)
    run.add_argument("--only", default="", help="part of the names of the programs to run")
    run.add_argument("-o", "--out", type=Path, required=True)
    for name, text in (("compare", "print where two files differ"), ("merge", "add records to a file of expectations")):
        command = commands.add_parser(name, help=text)
        command.add_argument("first", type=Path)
        command.add_argument("second", type=Path)
    options = parser.parse_args(arguments)
    if options.command == "run":
        return write(run_folder(options.folder, options.dialect, options.only), options.out)
    return (compare if options.command == "compare" else merge)(options.first, options.second)


def write(records: dict[str, dict], path: Path) -> int:
    """Write one record per line, so that a change of one program is a change of one line."""
    lines = (f"{json.dumps(name)}:{json.dumps(records[name], separators=(',', ':'))}" for name in sorted(records))
    path.write_text("{" + ",\n".join(lines) + "}\n")
    print(f"{len(records)} programs -> {path}", file=sys.stderr)
    return 0


def compare(expected: Path, found: Path) -> int:
    wanted, ours = json.loads(expected.read_text()), json.loads(found.read_text())
    different = 0
    for name in sorted(wanted.keys() & ours.keys()):
        said = differences(wanted[name], ours[name])
        different += bool(said)
        print(*([f"{name}:"] + [f"    {each}" for each in said] if said else []), sep="\n", end="\n" if said else "")
    print(f"{different} of {len(wanted.keys() & ours.keys())} differ, {len(wanted.keys() - ours.keys())} are not run")
    return int(different > 0)


def merge(new: Path, expected: Path) -> int:
    """Add the records of a file to the expectations, without what the comparison does not need."""
    known = json.loads(expected.read_text()) if expected.exists() else {}
    return write(known | {name: trimmed(record) for name, record in json.loads(new.read_text()).items()}, expected)


def trimmed(record: dict) -> dict:
    kept = {key: value for key, value in record.items() if key in (*RECORD, *DYNAMIC)}
    if "error" in kept:
        kept["error"] = {key: value for key, value in kept["error"].items() if key in ERROR}
    if "values" in kept:
        kept["values"] = {name: coarse(value) for name, value in kept["values"].items()}
    return kept


def coarse(description: dict) -> dict:
    """Return a description of a number with five digits of its quantiles, or none where its values are counted."""
    if "counts" in description:
        return {key: value for key, value in description.items() if key != "quantiles"}
    if "quantiles" in description:
        return description | {"quantiles": [float(f"{value:.5g}") for value in description["quantiles"]]}
    return description


sys.exit(main(sys.argv[1:]))
