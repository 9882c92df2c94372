"""What the caller of `load` decides, and what is found out: the dialect, parameters, the world model, modules."""

import numpy as np
import pytest

from scenic_lite import Domain, ScenicError, load

DIALECTS = [
    ("ego = Object", 2),
    ("ego = new Object", 3),
    ("# scenic: 3\nego = Object at 1 @ 2", 3),
    ("#! dialect: 2\nego = new Object", 2),
    ("# scenic: 3.1.1\nego = new Object", 3),
    ("# Scenic: a program about nothing\nego = new Object", 3),
    ("new = 3\nego = Object at new @ 2", 2),
    ("# new Object\nx = 'new Object'\nego = Object", 2),
]


@pytest.mark.parametrize(("text", "dialect"), DIALECTS)
def test_the_dialect_is_found_out(text, dialect):
    assert load(text).dialect == dialect


def test_an_explicit_dialect_wins():
    assert load("# scenic: 3\nego = new Object", dialect=2).dialect == 2


def test_a_dialect_that_does_not_exist_is_underlined():
    with pytest.raises(ScenicError) as caught:
        load("# scenic: 4\nego = Object")
    assert (caught.value.line, caught.value.column) == (1, 11)
    assert "write # scenic: 2 or # scenic: 3" in str(caught.value)


def test_parameters_of_the_caller_win_over_all():
    text = "param a = Range(0, 1), b = 2\nparam a = 3\nego = new Object at globalParameters.a @ 0"
    program = load(text, params={"a": 7, "c": [1, "x"]})
    assert program.params == {"a": 7, "b": 2, "c": [1, "x"]}
    assert program.instantiate(np.zeros((1, program.dim))).positions[0, 0, 0] == 7


@pytest.mark.parametrize("wrong", [{"params": 3}, {"params": {1: 2}}, {"params": {"a": object()}}, {"model": 3}])
def test_arguments_that_mean_nothing(wrong):
    with pytest.raises(TypeError):
        load("ego = new Object", **wrong)


@pytest.fixture
def folder(tmp_path):
    """Return a program's folder with modules, and packages in it."""
    files = {
        "shop.scenic": "param shared = 3\nsize = 4\n_own = 1\ncount = 0\ndef bump():\n    return count + 1\n",
        "world.scenic": "param time = 12, sky = 'grey'\nkind = 'world'\n",
        "other.scenic": "param time = 13\nkind = 'other'\n",
        "hero.scenic": "ego = new Object at 40 @ 0\n",
        "pack/one.scenic": "from pack.sub.two import deep\nimport pack.sub.two as two\none = deep + two.deep\n",
        "pack/sub/two.scenic": "deep = 10\n",
        "round.scenic": "import trip\n",
        "trip.scenic": "import round\n",
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    return tmp_path


def params_of(folder, text, **arguments):
    (folder / "main.scenic").write_text("ego = new Object\n" + text)
    return load(folder / "main.scenic", **arguments).params


MODULES = [
    ("from shop import *\nimport shop\nparam value = (size, count, shop.bump())", (4, 0, 1)),
    ("import shop\nshop.count = 5\nparam value = shop.bump()", 6),
    ("import pack.one as one\nfrom pack.sub.two import deep as d\nparam value = (one.one, d)", (20, 10)),
    ("model world\nparam value = (kind, globalParameters.time)", ("world", 12)),
    ("param time = 1\nmodel world\nparam value = globalParameters.time", 1),
    ("param shared = 1\nimport shop\nparam value = globalParameters.shared", 3),
]


@pytest.mark.parametrize(("text", "value"), MODULES)
def test_modules(folder, text, value):
    assert params_of(folder, text)["value"] == value


def test_the_caller_replaces_the_world_model(folder):
    text = "model world\nparam value = (kind, globalParameters.time)"
    assert params_of(folder, text, model="other")["value"] == ("other", 13)
    assert params_of(folder, "param value = kind", model="other")["value"] == "other"
    domain = Domain("there", {"there": folder / "world.scenic"}, default_model="there")
    (folder / "main.scenic").write_text("ego = new Object\nparam value = kind")
    assert load(folder / "main.scenic", domain, model="other").params["value"] == "other"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("import round", "imports itself in a circle"),
        ("import numpy", "there is no module 'numpy'"),
        ("from .. import shop", "dots before the name of a module are not supported"),
        ("import pack.one", "a module in a folder is imported by a name of its own"),
        ("from pack.sub import two", "there is no module 'pack.sub'"),
        ("from shop import price", "shop has no 'price'"),
        ("import math\nmath.pi = 3", "the attributes of a module cannot be assigned"),
    ],
)
def test_wrong_imports(folder, text, message):
    with pytest.raises(ScenicError) as caught:
        params_of(folder, text)
    assert message in caught.value.message
    assert caught.value.place is not None


def test_the_ego_of_a_module(folder):
    """It is the program's where that has none, in Scenic 3; in Scenic 2 it stays the module's."""
    (folder / "main.scenic").write_text("import hero\nparam value = ego.position.x\n")
    assert load(folder / "main.scenic", dialect=3).params["value"] == 40
    with pytest.raises(ScenicError):
        load(folder / "main.scenic", dialect=2)
    assert params_of(folder, "import hero\nparam value = ego.position.x")["value"] == 0


def test_what_a_program_prints_is_kept_and_goes_nowhere_else(capsys):
    text = """
print("lanes:", 3, [1, 2.5])
print(Range(0, 1), "x", sep="-")
print()
behavior B():
    print("in a match")
    wait
ego = new Object with behavior B
for i in range(3000):
    print(i)
"""
    program = load(text)
    assert program.printed[:3] == ("lanes: 3 [1, 2.5]", "(random)-x", "")
    assert len(program.printed) == 1000 and program.printed[-1] == "996"
    assert capsys.readouterr() == ("", "")


def test_a_name_of_the_library_says_where_it_lives(tmp_path):
    (tmp_path / "moves.scenic").write_text("speed = 3\nbehavior Dribble():\n    wait\n")
    domain = Domain("toy", {"toy.moves": tmp_path / "moves.scenic"})
    with pytest.raises(ScenicError) as caught:
        load("ego = Object at 0 @ 0, with behavior Dribble()", domain)
    assert caught.value.hint == "it lives in toy.moves: from toy.moves import Dribble"
    with pytest.raises(ScenicError) as caught:
        load("ego = Object at 0 @ sped", domain)
    assert caught.value.hint == ""


def test_a_module_gives_all_names_but_those_with_an_underscore(tmp_path):
    (tmp_path / "lib.scenic").write_text("a = 1\n_b = 2\n")
    (tmp_path / "main.scenic").write_text("from lib import *\nego = Object at a @ 0\n")
    load(tmp_path / "main.scenic")
    (tmp_path / "main.scenic").write_text("from lib import *\nego = Object at a @ _b\n")
    with pytest.raises(ScenicError, match="name '_b' is not defined"):
        load(tmp_path / "main.scenic")


def test_a_misspelt_parameter_of_the_caller_is_warned_of():
    text = "param gravity = -9\nego = Object"
    (warning,) = load(text, params={"gravty": -3}).warnings
    assert "'gravty'" in warning.message and warning.hint == "did you mean 'gravity'?"
    assert not load(text, params={"gravity": -3, "weather": "dry"}).warnings


def test_a_module_that_lists_its_public_names_gives_no_others(tmp_path):
    (tmp_path / "lib.scenic").write_text('__all__ = ["a", "_b"]\na = 1\n_b = 2\nc = 3\n')
    (tmp_path / "main.scenic").write_text("from lib import *\nego = Object at a @ _b\n")
    load(tmp_path / "main.scenic")
    (tmp_path / "main.scenic").write_text("from lib import *\nego = Object at a @ c\n")
    with pytest.raises(ScenicError, match="name 'c' is not defined"):
        load(tmp_path / "main.scenic")
    (tmp_path / "lib.scenic").write_text('__all__ = ["a"]\n')
    with pytest.raises(ScenicError, match="lib has no 'a', which its `__all__` lists"):
        load(tmp_path / "main.scenic")
