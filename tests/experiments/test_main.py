"""The command line as a user meets it: help, errors in one sentence, exit codes."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
import torch

from regista.experiments.__main__ import COMMANDS, main
from regista.experiments.run.errors import refused
from regista.experiments.run.progress import Progress, count, duration
from ued.methods import METHODS

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize(
    ("argv", "code", "sentence"),
    [
        (["trian"], 2, "regista: unknown command trian (did you mean 'train'?); see regista --help"),
        (["--verbose"], 2, "regista: unknown flag --verbose; see regista --help"),
        (["train", "--sed", "3"], 2, "regista: unknown flag --sed (did you mean '--seed'?)"),
        (
            ["train", "1v1Restrictd"],
            2,
            "regista: unknown minigame '1v1Restrictd' (did you mean '1v1Restricted'",
        ),
        (["train", "nowhere.scenic"], 2, "regista: there is no program nowhere.scenic"),
        (
            ["train", "--method", "pared"],
            2,
            "regista: unknown method 'pared' (did you mean 'paired'?); methods are dr, minimax, paired, ",
        ),
        (["train", "--resume", "nowhere"], 1, "regista: nowhere is not a run folder: it has no config.json"),
        (["train", "--num-envs", "0"], 2, "regista: --num-envs: must be at least 1, got 0"),
        (["train", "--clip-coef", "-1"], 2, "regista: --clip-coef: must be positive, got -1"),
        (["train", "--representation", "raw"], 2, "regista: training needs observations that are arrays; 'raw' is for"),
        (["train", "--out", "/dev/null/run"], 1, "regista: cannot write /dev/null/run: Not a directory"),
        (["evaluate"], 2, "regista: evaluate needs at least one run folder, such as runs/1v1Restricted-paired-0"),
        (["evaluate", "nowhere"], 1, "regista: nowhere is not a run folder: it has no config.json"),
        (["compare", "--seeds", "0"], 2, "regista: --seeds: must be at least 1, got 0"),
        (
            ["compare", "--methods", "dr", "dr"],
            2,
            "regista: methods must be one or more, without repetition, got dr dr",
        ),
        (
            ["compare", "--methods", "dr", "plt"],
            2,
            "regista: unknown method 'plt' (did you mean 'plr'?); methods are dr, ",
        ),
        (["inspect"], 2, "regista: inspect needs a program: a minigame's name or the path of a .scenic file"),
        (
            ["inspect", "1v1Free", "--theta", "0", "2"],
            2,
            "regista: --theta: must be at most 1, got 2.0",
        ),
        (
            ["study", "single"],
            2,
            "regista: the command study has moved: python -m lab.studies, in a checkout",
        ),
        (["transfer", "a", "--policies", "best"], 2, "regista: policies must be sampled, greedy or both, got best"),
        (
            ["benchmark", "--suite", "grf"],
            2,
            "regista: benchmark --suite has moved: python -m lab.benchmarks --suite, in a checkout",
        ),
        (["benchmark", "--seconds", "0"], 2, "regista: --seconds: must be positive, got 0.0"),
    ],
)
def test_errors_are_one_sentence(argv, code, sentence, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(argv) == code
    captured = capsys.readouterr()
    assert captured.err.startswith(sentence)
    assert len(captured.err.splitlines()) == 1
    assert captured.out == ""


def test_an_error_in_a_program_shows_its_place(tmp_path, capsys):
    path = tmp_path / "mine.scenic"
    path.write_text("model football.model\nego = LeftCM at 0 @ 0\nBall at 1 @\n")
    assert main(["inspect", str(path)]) == 1
    first = capsys.readouterr().err.splitlines()[0]
    assert ":3:" in first and "Traceback" not in first


def test_debug_shows_the_traceback(tmp_path):
    from regista.experiments.run.errors import CommandError

    with pytest.raises(CommandError):
        main(["train", "--resume", str(tmp_path), "--debug"])


def test_help_lists_the_commands(capsys):
    assert main(["--help"]) == 0
    text = capsys.readouterr().out
    assert all(name in text for name in COMMANDS)
    assert main([]) == 2


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_help(command, capsys):
    with pytest.raises(SystemExit) as found:
        main([command, "--help"])
    assert found.value.code == 0
    text = capsys.readouterr().out
    assert text.startswith(f"usage: regista {command}") and text.count("\n") <= 100


@pytest.mark.parametrize("method", METHODS.values(), ids=METHODS)
def test_the_settings_of_a_method_have_a_page(method, capsys):
    with pytest.raises(SystemExit):
        main(["train", "--help", method.name])
    flags = set(re.findall(r"^  --(?:no-)?([\w-]+)\.", capsys.readouterr().out, re.M))
    assert flags == {method.group.replace("_", "-")}


@pytest.mark.slow
def test_help_loads_nothing_heavy():
    """`import regista` registers the minigames, so Gymnasium and NumPy are loaded: a tenth of a second."""
    code = (
        "import sys; from regista.experiments.__main__ import main; main(['--help']); "
        "print([name for name in ('torch', 'numba', 'rerun', 'matplotlib') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


# ---------------------------------------------------------------- inspect, benchmark


def test_inspect_shows_parameters_objects_and_acceptance(capsys):
    assert main(["inspect", "1v1Free"]) == 0
    text = capsys.readouterr().out
    for piece in ("D = 6 free parameters", "ego.x", "opponent", "LeftCM", "% of 4096 draws are valid"):
        assert piece in text


def test_inspect_warns_of_slips_once(capsys, tmp_path):
    path = tmp_path / "slip.scenic"
    path.write_text("ego = LeftCM with bahavior 3\nBall\n")
    assert main(["inspect", str(path), "--n", "1", "--png", str(tmp_path / "scene.png")]) == 0
    assert capsys.readouterr().err.splitlines() == [
        "warning: slip.scenic:1:14: LeftCM has no property 'bahavior' (did you mean 'behavior'?)",
        "    ego = LeftCM with bahavior 3",
        "                 ^^^^^^^^^^^^^^^",
    ]


def test_inspect_shows_what_a_theta_means(capsys):
    assert main(["inspect", "1v1Free", "--theta", "0", "0", "0.5", "0.5", "0", "0"]) == 0
    text = capsys.readouterr().out
    assert "this θ describes a valid scene" in text and "+0.50" in text


@pytest.mark.slow
@pytest.mark.drawn
def test_inspect_shows_text_and_scenes(capsys, tmp_path):
    assert main(["inspect", "1v1Free", "--show", "tokens"]) == 0
    assert "'ego'" in capsys.readouterr().out
    assert main(["inspect", "1v1Free", "--show", "nodes"]) == 0
    assert "Specifier name='on'" in capsys.readouterr().out
    png = tmp_path / "scenes.png"
    assert main(["inspect", "1v1Free", "--show", "scenes", "--n", "4", "--png", str(png)]) == 0
    assert "scene 3: θ = " in capsys.readouterr().out
    assert png.stat().st_size > 10_000


@pytest.mark.long
def test_benchmark_prints_json_and_a_table(capsys, monkeypatch):
    monkeypatch.setattr("regista.experiments.commands.benchmark.WARM_UP", 1)
    words = ["benchmark", "--num-envs", "4", "--seconds", "0.01"]
    assert main([*words, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["machine"]["cores"] >= 1
    speeds = found["env_steps_per_second"]
    assert list(speeds) == ["simulator, 1v1", "simulator, 22 players", "training, PAIRED, 1v1"]
    assert all(speed > 0 for speed in speeds.values())
    assert main([*words, "--threads", "2"]) == 0
    machine, _, head, *_ = capsys.readouterr().out.splitlines()
    assert machine.endswith("threads 2") and head.startswith("measurement ")


# ---------------------------------------------------------------- progress


class Screen:
    """A stream that is a terminal, or is not."""

    def __init__(self, tty):
        self.text, self.tty = "", tty

    def isatty(self):
        return self.tty

    def write(self, text):
        self.text += text

    def flush(self):
        pass


def test_progress_is_a_bar_on_a_terminal_and_a_line_elsewhere():
    for tty in (True, False):
        screen = Screen(tty)
        progress = Progress(1000, stream=screen)
        progress.show(500, {"return": 0.25, "regret": float("nan")})
        assert "50%" in screen.text and "return +0.25" in screen.text and "nan" not in screen.text
        assert ("━" in screen.text) == tty
        progress.finish("done")
        assert screen.text.endswith("done\n")


def test_the_time_left_is_told_from_the_pace_after_the_first_steps(monkeypatch):
    now = iter([0.0, 100.0, 200.0])
    monkeypatch.setattr("regista.experiments.run.progress.time.monotonic", lambda: next(now, 300.0))
    screen = Screen(False)
    progress = Progress(1000, begun=100, stream=screen)
    for steps in (100, 200, 300):  # the first hundred wait for the compiler
        progress.show(steps)
    assert screen.text.splitlines() == [" 10%  100 steps", " 20%  200 steps", " 30%  300 steps  1/s  12 min left"]


def test_numbers_are_short():
    assert [count(n) for n in (950, 12_345, 4_560_000)] == ["950", "12.3k", "4.56M"]
    assert [duration(s) for s in (42, 180, 3900 * 2)] == ["42 s", "3 min", "2 h 10"]


def test_weights_of_another_network_are_told_in_a_line():
    with pytest.raises(RuntimeError) as caught:
        torch.nn.Linear(2, 3).load_state_dict({"weight": torch.zeros(3, 2)})
    assert refused(caught.value) == 'its Linear has other weights: Missing key(s) in state_dict: "bias"'
