"""However a command ends, it is one line, the right code, and nobody is left behind."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest

from regista.experiments.__main__ import main
from regista.experiments.run.errors import run_command
from regista.experiments.run.launch.signals import StopRequest
from tests.attacks.interrupts import PREPARED, ROOT, attack, started


def ask(number: int = signal.SIGINT) -> None:
    os.kill(os.getpid(), number)


@pytest.mark.parametrize(("number", "word"), [(2, "interrupted"), (15, "terminated"), (1, "hung up")])
def test_a_signal_ends_a_command_with_one_line(number, word, capsys, monkeypatch):
    monkeypatch.setattr("regista.experiments.run.launch.signals.forget_terminal", lambda: None)
    before = signal.signal(number, signal.SIG_DFL)  # nohup may have started the tests
    try:
        assert run_command(lambda _: ask(number) or 0, []) == 128 + number
    finally:
        signal.signal(number, before)
    assert capsys.readouterr().err == f"regista: {word}\n"


def test_an_error_that_a_signal_became_is_the_signal(capsys):
    def command(_: list[str]) -> int:
        try:
            ask()
        except KeyboardInterrupt as error:
            raise RuntimeError("an error in a place of its own") from error
        return 0

    assert run_command(command, []) == 130
    assert capsys.readouterr().err == "regista: interrupted\n"


def test_a_signal_that_was_swallowed_still_counts(capsys):
    def command(_: list[str]) -> int:
        with suppress(KeyboardInterrupt):
            ask()
        return 0

    assert run_command(command, []) == 130


@pytest.mark.slow
def test_an_object_that_a_signal_left_half_made_says_nothing():
    lines = """
import os, signal
from regista.experiments.run.errors import run_command

class Half:
    def __init__(self):
        os.kill(os.getpid(), signal.SIGTERM)
        self.handle = 1

    def __del__(self):
        self.handle

raise SystemExit(run_command(lambda _: Half() and 0, [], for_good=True))
"""
    ended = subprocess.run([sys.executable, "-c", lines], cwd=ROOT, capture_output=True, text=True, timeout=60)
    assert (ended.returncode, ended.stderr) == (143, "regista: terminated\n")


def test_handlers_are_as_before(capsys):
    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)]
    run_command(lambda _: ask() or 0, [])
    with StopRequest() as stop, stop:
        ask(signal.SIGTERM)
    assert stop.exit_code == 143
    assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)] == before


def test_what_was_to_be_ignored_is_ignored():
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)  # nohup
    try:
        assert run_command(lambda _: ask(signal.SIGHUP) or 0, []) == 0
    finally:
        signal.signal(signal.SIGHUP, before)


@pytest.mark.parametrize("words", [["train", "--help"], pytest.param(["inspect", "1v1Free"], marks=pytest.mark.slow)])
def test_a_reader_that_has_gone_is_no_error(words):
    command = [sys.executable, "-m", "regista", *words]
    process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    process.stdout.close()
    said = process.stderr.read().decode()
    assert process.wait() in (0, 141) and said == ""


@pytest.mark.slow
def test_a_terminal_that_has_gone_is_no_error():
    master, terminal = os.openpty()
    os.close(master)
    command = [sys.executable, "-m", "regista", "train", "--help"]
    ended = subprocess.run(command, cwd=ROOT, stdout=terminal, stderr=subprocess.PIPE)
    os.close(terminal)
    assert ended.returncode == 141 and ended.stderr == b""


def test_an_error_of_the_disk_is_not_taken_for_one_of_the_terminal(capsys):
    def command(_: list[str]) -> int:
        raise OSError(errno.EIO, os.strerror(errno.EIO))  # as of a file that is open: nobody knows its name

    assert run_command(command, []) == 1
    assert capsys.readouterr().err == "regista: [Errno 5] Input/output error\n"


@pytest.mark.slow
@pytest.mark.long
def test_commands_are_interrupted(tmp_path: Path):
    for words in PREPARED:
        assert main([word.format(run=tmp_path / "run") for word in words]) == 0
    found = attack(4, 7414, tmp_path)  # after 1 to 3 s, by three signals; `make torture` goes on
    assert found["ended"] > 1


@pytest.mark.long
def test_runs_end_with_whoever_started_them(tmp_path: Path):
    words = ["compare", "1v1Free", "--methods", "dr", "--seeds", "1", "--num-envs", "8", "--out", str(tmp_path)]
    compare = started(words)
    log = tmp_path / "dr-0" / "train.log"
    while compare.poll() is None and not (tmp_path / "dr-0" / "metrics.csv").exists():
        time.sleep(0.05)
    compare.kill()
    compare.communicate()
    here = str(tmp_path).encode()
    for _ in range(600):
        running = [each for each in Path("/proc").glob("[0-9]*") if here in _command(each)]
        if not running:
            break
        time.sleep(0.1)
    assert not running and log.exists()


def _command(process: Path) -> bytes:
    try:
        return (process / "cmdline").read_bytes()
    except OSError:
        return b""
