"""With the root of a checkout on `sys.path`, `import envs` and `import regista.envs` give the same module objects."""

import sys

import pytest

from tests.wheels import ROOT, run

ONCE = """
import sys, warnings
warnings.simplefilter("error")  # Gymnasium warns of an id that is registered twice
{first}
import envs, envs.toy_world, experiments.run.errors, minigames
import envs.football.constants as constants
from minigames.suites import Minigame
import regista.envs, regista.envs.toy_world, regista.experiments.run.errors, regista.minigames.suites
import regista.envs.football.constants

assert envs is regista.envs and envs.toy_world is regista.envs.toy_world
assert constants is regista.envs.football.constants and constants is sys.modules["envs.football.constants"]
assert minigames is regista.minigames and Minigame is regista.minigames.suites.Minigame
assert experiments.run.errors.UsageError is regista.experiments.run.errors.UsageError
assert envs.toy_world.__spec__.name == envs.toy_world.__name__ == "regista.envs.toy_world"
bare = [name for name in sys.modules if name.partition(".")[0] in ("kernels", "envs", "minigames", "experiments")]
assert all(sys.modules[name] is sys.modules[f"regista.{{name}}"] for name in bare), bare
"""


def python(*words, folder=ROOT):
    return run([sys.executable, *words], folder)


@pytest.mark.slow
@pytest.mark.parametrize("first", ["import envs", "import minigames", "import experiments", "import regista.envs"])
def test_a_module_has_one_copy_whichever_name_comes_first(first):
    done = python("-c", ONCE.format(first=first))
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("name", ["envs.nothing", "envs.football.nothing"])
def test_a_module_that_is_not_there_is_missing(name):
    done = python("-c", f"import {name}")
    assert done.stderr.endswith(f"ModuleNotFoundError: No module named '{name}'\n")


@pytest.mark.slow
def test_a_module_is_run_by_its_bare_name():
    told = [python("-m", name, "--help") for name in ("regista", "experiments")]
    assert told[0].stdout == told[1].stdout != ""


@pytest.mark.slow
@pytest.mark.parametrize("first", ["import regista.envs", "import regista.experiments.__main__"])
def test_an_envs_of_yours_is_yours(tmp_path, first):
    (tmp_path / "envs").mkdir()
    (tmp_path / "envs" / "__init__.py").write_text("football = 'mine'\n")
    (tmp_path / "envs" / "mine.py").touch()
    code = f"import sys; sys.path.append({str(ROOT)!r}); {first}; import envs.mine; print(envs.football)"
    done = python("-c", code, folder=tmp_path)
    assert done.stdout == "mine\n", done.stderr
