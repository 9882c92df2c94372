"""`regista completion`: the script completes in bash what a command really takes."""

import shlex
import shutil
import subprocess

import pytest

from regista.experiments.__main__ import COMMANDS, main
from regista.experiments.commands import completion
from regista.experiments.commands.completion import SHELLS, words_of_commands
from regista.experiments.run import shipped
from ued.methods import METHODS


@pytest.fixture(scope="module")
def script():
    return completion.bash(words_of_commands(), completion.games())


def completed(script, line):
    """Return what bash offers for the last word of a command line."""
    words = line.split(" ")
    asked = f"COMP_WORDS=({' '.join(map(shlex.quote, words))}); COMP_CWORD={len(words) - 1}; _regista"
    done = subprocess.run(
        ["bash", "--norc", "-c", f'{script}\n{asked}\nprintf "%s\\n" "${{COMPREPLY[@]}}"'],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert done.stderr == ""
    return done.stdout.split()


@pytest.mark.parametrize(
    ("line", "offered"),
    [
        ("regista tra", ["train", "transfer"]),
        ("regista train --total", ["--total-env-steps"]),
        ("regista train --method pl", ["plr"]),
        ("regista compare --methods dr pl", ["plr"]),  # the second value of a flag
        ("regista compare --methods dr plr --see", ["--seeds"]),
        ("regista compare --seeds 3 Gau", ["Gauntlet"]),
        ("regista play --player shi", shipped.names()),
        ("regista play --player runs/", []),  # files
        ("regista evaluate shi", shipped.names()),
        ("regista play 1v1Free --scene har", ["hard", "hard_crossing"]),
        ("regista play maze --scene Lab", ["Labyrinth", "Labyrinth2"]),
        ("regista train --help pl", ["plr"]),
        ("regista list --help sol", ["solved"]),
        ("regista train --preset ", ["fast", "thesis"]),
        ("regista play Gau", ["Gauntlet"]),
        ("regista play maze --player runs/x --vid", ["--video"]),
        ("regista evaluate Gau", []),
        ("regista completion ", list(SHELLS)),
        ("regista train --engine g", ["grf"]),
        ("regista play 1v1Free --engine ", ["regista", "grf"]),
        ("regista train --plr.score max", ["max_mc"]),
        ("regista train --network c", ["cnn"]),
        ("regista train --network my_net", []),  # files
        ("regista train --pixels s", ["sparse"]),
        ("regista train --out Gau", []),
        ("regista clone --minigame Gau", ["Gauntlet"]),
        ("regista compare --seeds ", []),
        ("regista train --no-record Gau", ["Gauntlet"]),  # a flag without a value
        ("regista evaluate --csv shi", []),
    ],
)
def test_bash_offers_what_fits(script, line, offered):
    assert completed(script, line) == offered


def test_every_flag_is_known():
    known = words_of_commands()
    assert list(known) == list(COMMANDS)
    assert {"--config", "--plr.replay-prob", "--no-record", "--help"} <= set(known["train"].flags)
    assert known["train"].values["--method"] == list(METHODS)


@pytest.mark.slow
@pytest.mark.parametrize("shell", SHELLS)
def test_the_script_is_one_that_the_shell_reads(shell, tmp_path, capsys):
    assert main(["completion", shell]) == 0
    script = capsys.readouterr().out
    assert all(name in script for name in COMMANDS) and "learning-rate" in script
    (tmp_path / "script").write_text(script)
    if shutil.which(shell):
        assert subprocess.run([shell, "-n", str(tmp_path / "script")], capture_output=True).returncode == 0
    if shell == "fish":  # each line is a whole command, also where fish is not installed
        assert all(shlex.split(line)[:3] == ["complete", "-c", "regista"] for line in script.splitlines())
        of_train = [line for line in script.splitlines() if "from train" in line]
        assert any("-l engine -ra" in line and "grf" in line for line in of_train)
        assert any(line.endswith("-l out -r") for line in of_train)


@pytest.mark.parametrize(("words", "message"), [([], "the name of a shell"), (["bsh"], "did you mean 'bash'?")])
def test_other_shells_are_refused(words, message, capsys):
    assert main(["completion", *words]) == 2
    assert message in capsys.readouterr().err
