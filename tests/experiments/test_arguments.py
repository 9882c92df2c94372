"""The command line from dataclasses: flags, groups, types, what is refused and how."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import pytest

from regista.experiments.run.arguments import group, option, parse, positional, typed_settings
from regista.experiments.run.errors import UsageError
from ued.config import setting


@dataclass(frozen=True)
class Inner:
    learning_rate: float = setting(1e-3, "step size")
    layers: int = setting(2, "hidden layers")

    def __post_init__(self):
        if self.layers < 1:
            raise ValueError(f"layers must be at least 1, got {self.layers}")


@dataclass(frozen=True)
class Teacher:
    fraction: float = setting(0.5, "share")
    inner: Inner = group(Inner, "inner", prefix="inner.")


@dataclass(frozen=True)
class Outer:
    game: str = positional("what to play", default="chess")
    num_envs: int = setting(64, "environments")
    out: Path | None = setting(None, "where to")
    record: bool = setting(True, "record it")
    kind: Literal["fast", "slow"] = setting("fast", "how")
    words: tuple[str, ...] = setting(("a", "b"), "some words")
    move: tuple[str, ...] = option((), "a move", "-m", repeated=True)
    ppo: Inner = group(Inner, "PPO")
    teacher: Teacher = group(Teacher, "teacher", prefix="teacher.")


def read(*argv):
    return parse(Outer(), argv, "play", "Play.")


def test_nothing_typed_leaves_the_base_as_it_is():
    assert read() == Outer()
    assert typed_settings(Outer(), [], "play", "") == {}


def test_every_kind_of_field():
    found = read("go", "--num-envs", "128", "--out", "x/y", "--no-record", "--kind", "slow", "--words", "c", "d", "e")
    assert found == Outer(game="go", num_envs=128, out=Path("x/y"), record=False, kind="slow", words=("c", "d", "e"))


def test_a_repeated_flag_adds_one_value_each_time_and_may_be_short():
    assert read("-m", "e4", "go", "--move", "e5").move == ("e4", "e5")
    assert read("-m", "e4", "go").game == "go"


def test_nested_fields_are_flat_or_prefixed_at_every_depth():
    found = read("--learning-rate", "0.1", "--teacher.fraction", "0.25", "--teacher.inner.layers", "3")
    assert found.ppo == Inner(learning_rate=0.1)
    assert found.teacher == Teacher(fraction=0.25, inner=Inner(layers=3))


@dataclass(frozen=True)
class Band:
    least: int = setting(1, "least")
    most: int = setting(2, "most")

    def __post_init__(self):
        if self.least > self.most:
            raise ValueError(f"least must be at most {self.most}, got {self.least}")


@dataclass(frozen=True)
class Picture:
    band: Band = group(Band, "band")


@pytest.mark.parametrize("order", [("--least", "5", "--most", "6"), ("--most", "6", "--least", "5")])
def test_settings_that_check_each_other_are_set_at_once(order):
    assert parse(Picture(), order, "draw", "Draw.").band == Band(5, 6)


@pytest.mark.parametrize(("text", "number"), [("5e6", 5_000_000), ("2_000", 2000), ("-3", -3)])
def test_whole_numbers_may_be_written_short(text, number):
    assert read(f"--num-envs={text}").num_envs == number


@pytest.mark.parametrize(
    ("argv", "sentence"),
    [
        (["--num-env", "3"], "unknown flag --num-env (did you mean '--num-envs'?)"),
        (["--teacher.fracton=1"], "unknown flag --teacher.fracton (did you mean '--teacher.fraction'?)"),
        (["go", "further"], "unexpected argument 'further'"),
        (["--num-envs", "many"], "--num-envs: 'many' is not a number; see regista play --help"),
        (["--num-envs", "1.5"], "--num-envs: '1.5' is not an integer; see regista play --help"),
        (["--learning-rate", "nan"], "--learning-rate: 'nan' is not a finite number; see regista play --help"),
        (["--num-envs"], "--num-envs: expected one argument; see regista play --help"),
        (["--layers", "0"], "layers must be at least 1, got 0"),
    ],
)
def test_what_is_refused_and_how(argv, sentence):
    with pytest.raises(UsageError) as found:
        read(*argv)
    assert str(found.value) == sentence
    assert found.value.exit_code == 2


def test_help_names_every_flag_with_its_default(capsys):
    with pytest.raises(SystemExit) as found:
        read("--help")
    assert found.value.code == 0
    text = capsys.readouterr().out
    assert text.startswith("usage: regista play GAME [flags]\n")
    for piece in (
        "--num-envs N",
        "(default 64)",
        "--record, --no-record",
        "--teacher.inner.layers N",
        "PPO:",
        "{fast,slow}",
    ):
        assert piece in text


@dataclass(frozen=True)
class Paged:
    out: Path | None = setting(None, "where to")
    teacher: Teacher = group(
        Teacher, "the teacher", prefix="teacher.", topics={"teacher": "the teacher", "guide": "a guide"}
    )


def page(capsys, *words):
    with pytest.raises(SystemExit) as found:
        typed_settings(Paged(), ["--help", *words], "play", "Play.")
    assert found.value.code == 0
    return capsys.readouterr().out


def test_a_group_with_topics_has_a_page_of_its_own(capsys):
    first = page(capsys)
    assert "--out PATH" in first and "--teacher" not in first
    assert first.endswith(
        "more settings: regista play --help TOPIC\n"
        "  teacher         the teacher\n  guide           a guide\n  all             every flag\n"
    )
    for topic in ("teacher", "guide"):
        text = page(capsys, topic)
        assert "--teacher.fraction X" in text and "--teacher.inner.layers N" in text and "--out" not in text
    text = page(capsys, "all")
    assert "--out PATH" in text and "--teacher.inner.layers N" in text


def test_a_topic_that_there_is_not():
    with pytest.raises(
        UsageError, match=r"^--help has no page 'teecher' \(did you mean 'teacher'\?\); see regista play"
    ):
        typed_settings(Paged(), ["--help", "teecher"], "play", "Play.")
