"""What an environment is asked that it cannot do is refused in a sentence; nothing is guessed."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest

from regista.envs.football.vector_env import FootballVectorEnv
from regista.experiments.__main__ import main
from tests.attacks.calls import attack
from ued import (
    PLR,
    ACCELConfig,
    GymUPOMDP,
    Paired,
    PLRConfig,
    PPOConfig,
    RepairedConfig,
    UPOMDPWrapper,
    VectorUPOMDP,
)
from ued.core.level_space import LevelError, ThetaError
from ued.core.parameters import Choice, Integer, LogRange, Range, ThetaMap
from ued.probes import Frontier


def make() -> Frontier:
    env = Frontier(3, 5, 2)
    env.reset(seed=0)
    return env


def test_an_option_that_does_not_exist() -> None:
    with pytest.raises(ValueError, match="reset has no option 'thetas'; its options are 'theta' and 'reset_mask'"):
        make().reset(options={"thetas": np.zeros((3, 2))})


@pytest.mark.parametrize("options", [[], (), 0, "theta", iter(())])
def test_options_that_are_none(options: object) -> None:
    with pytest.raises(ValueError, match="reset takes a dict of options, or None, got"):
        make().reset(options=options)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("name", "value"), [("place", [9, 0, 0]), ("place", [0]), ("levels", np.zeros(3)), ("np_random", None)]
)
def test_a_state_that_is_none(name: str, value: object) -> None:
    env = make()
    state, before = env.get_state(), env.levels.copy()
    with pytest.raises(ValueError):
        env.set_state(state | {name: value})
    with pytest.raises(ValueError, match=f"a state is what get_state returned, a dict with '{name}', got"):
        env.set_state({key: part for key, part in state.items() if key != name})
    for other in (19, None, []):
        with pytest.raises(ValueError, match="a state is what get_state returned"):
            env.set_state(other)  # type: ignore[arg-type]
    assert (env.levels == before).all()


def test_calls_that_are_made_wrongly() -> None:
    assert sum(attack(60, 0).values()) == 60  # `make torture` goes on


@pytest.mark.parametrize(
    "mask", [[True, False], [1, 0, 1], [0.0, 1.0, 1.0], [[True, True, False]], True, [2], ["yes", "no", "no"]]
)
def test_a_mask_of_another_shape_or_type(mask: object) -> None:
    env = make()
    with pytest.raises(ValueError, match=r"a mask must have shape \[3\] and dtype bool, got shape"):
        env.reset(options={"reset_mask": mask})
    with pytest.raises(ValueError, match="a mask must have"):
        env.reset_to_levels(env.sample_levels(1), mask)  # type: ignore[arg-type]


def test_levels_of_a_program_that_is_not_there() -> None:
    env = make()
    for program in (1, -1):
        levels = env.sample_levels(3)
        levels["program"][1] = program
        with pytest.raises(ValueError, match=f"a level has program {program}; 0 is the only program"):
            env.reset_to_levels(levels)
    with pytest.raises(ValueError, match=r"levels must be records of .*, got list"):
        env.reset_to_levels([1, 2, 3])  # type: ignore[arg-type]


@pytest.mark.parametrize("theta", [np.zeros((3, 2), complex), [[1j, 0]] * 3, [["a", "b"]] * 3, [[None, 0]] * 3])
def test_theta_that_is_no_real_number(theta: object) -> None:
    with pytest.raises(ThetaError):
        make().reset(options={"theta": theta})


@pytest.mark.parametrize("count", [0, -1, 2.0, True, None, "4"])
def test_a_number_of_environments_that_is_none(count: object) -> None:
    for attempt in (
        lambda: Frontier(count, 5, 2),  # type: ignore[arg-type]
        lambda: GymUPOMDP(lambda: None, lambda *_: None, 1, count),  # type: ignore[arg-type, return-value]
        lambda: FootballVectorEnv("minigames/one_v_one/free.scenic", count),  # type: ignore[arg-type]
    ):
        with pytest.raises(ValueError, match="num_envs must be a positive integer, got"):
            attempt()


def test_a_list_of_no_seeds_asks_for_no_seed() -> None:
    one, other = Frontier(3, 5, 2), Frontier(3, 5, 2)
    for env in (one, other):
        env.reset(seed=[None, None, None])
    assert (one.levels["theta"] != other.levels["theta"]).any()


def test_a_stream_that_is_none_is_refused() -> None:
    env = make()
    with pytest.raises(ValueError, match="np_random is not a valid state of a PCG64"):
        env.set_state(env.get_state() | {"np_random": {"bit_generator": "PCG64"}})


@pytest.mark.parametrize("words", [["--control", "none"], ["--control", "12"], ["--control", "nobody"]])
def test_a_match_that_nobody_plays(words: list[str], capsys: pytest.CaptureFixture) -> None:
    assert main(["play", "1v1Free", *words]) in (1, 2)
    said = capsys.readouterr().err
    assert said.startswith("regista: ") or "1v1" in said or "free.scenic" in said
    assert "Traceback" not in said


@pytest.mark.parametrize("kind", [Range, LogRange])
def test_a_range_the_wrong_way_round(kind: type) -> None:
    with pytest.raises(ValueError, match="the low end of a range must not exceed the high end, got 3 and 2"):
        kind(3, 2)
    with pytest.raises(ValueError):
        kind(1, np.nan)


@pytest.mark.parametrize("kind", [Range, LogRange, Integer])
def test_a_range_of_no_numbers(kind: type) -> None:
    with pytest.raises(ValueError, match="got 'a' and 'b'"):
        kind("a", "b")


def test_a_choice_of_a_list() -> None:
    with pytest.raises(ValueError, match=r"needs its values one by one, at least one; of a list, Choice\(\*values\)"):
        Choice(["ice", "grass"])


def test_a_choice_twice() -> None:
    with pytest.raises(ValueError, match=r"must differ, got 0\.5 twice"):
        Choice(0.5, 1.0, 0.5)
    Choice(np.zeros(2), np.zeros(2))  # whether arrays are equal is not asked


KINDS = {"length": Range(0.1, 2.0), "force": LogRange(1.0, 100.0), "poles": Integer(1, 3), "ground": Choice("a", "b")}
GOOD = {"length": 0.1, "force": 100.0, "poles": 3, "ground": "b"}


@pytest.mark.parametrize(
    "wrong",
    [
        {"length": 2.1},
        {"length": np.nan},
        {"length": "long"},
        {"force": -1.0},
        {"poles": 4},
        {"poles": 1.5},
        {"ground": "c"},
    ],
)
def test_values_that_are_none_of_their_parameters(wrong: dict) -> None:
    assert (np.abs(ThetaMap(KINDS).theta(GOOD)) <= 1).all()
    with pytest.raises(ValueError, match=f"{next(iter(wrong))} must be a value of .*, got"):
        ThetaMap(KINDS).theta(GOOD | wrong)


def one() -> gymnasium.Env:
    return gymnasium.make("CartPole-v1")


@pytest.mark.parametrize(
    ("message", "words"),
    [
        ("make_env must be a function", (one(), print, KINDS)),
        (r"make_env\(\) must return a gymnasium.Env, got None", (lambda: None, print, KINDS)),
        ("apply must be a function", (one, "length", KINDS)),
        ("theta must be a number of dimensions, a mapping", (one, print, ["length"])),
        ("valid must be a function", (one, print, KINDS, 2, "sync", "yes")),
        ("apply must be a function that applies length, force, poles, … to", (one, None, KINDS)),
    ],
)
def test_what_makes_no_upomdp(message: str, words: tuple) -> None:
    with pytest.raises(ValueError, match=message):
        GymUPOMDP(*words)


def test_ranges_that_nothing_applies_are_refused_by_every_adapter() -> None:
    sentence = "apply must be a function that applies length to an environment; None is for ued.Seeds"
    with pytest.raises(ValueError, match=sentence):
        UPOMDPWrapper(one(), None, {"length": (0.1, 2.0)})
    with pytest.raises(ValueError, match=sentence):
        VectorUPOMDP(lambda count: gymnasium.make_vec("CartPole-v1", count), None, {"length": (0.1, 2.0)})


PPO, LEVELS = PPOConfig(), PLRConfig()


@pytest.mark.parametrize(
    ("method", "words", "sentence"),
    [
        (PLR, (LEVELS, PPO), r"PLR\(upomdp, ppo, config\): ppo must be a PPOConfig, got PLRConfig\("),
        (PLR, (PPO, ACCELConfig()), r"PLR\(upomdp, ppo, config\): config must be a PLRConfig, got ACCELConfig\("),
        (PLR, (PPO, {"score": "mna"}), "config must be a PLRConfig, got {'score': 'mna'}"),
        (Paired, (None, RepairedConfig()), r"config must be a PairedConfig, got RepairedConfig\("),
    ],
)
def test_settings_of_something_else(method: Any, words: tuple, sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        method(make(), *words)


def test_settings_of_a_users_own_kind_are_accepted() -> None:
    class OwnConfig(PLRConfig):
        """More settings."""

    class Own(PLR):
        """Another method, which reads the settings of ACCEL."""

        def setup(self, config: ACCELConfig | None, seed: int) -> None:
            super().setup(config, seed)

    assert PLR(make(), PPO, OwnConfig()).env_steps == Own(make(), PPO, ACCELConfig()).env_steps == 0


def test_no_environment_for_a_method() -> None:
    with pytest.raises(ValueError, match=r"PLR trains on a UPOMDP, such as a ued.GymUPOMDP, got <TimeLimit"):
        PLR(one())  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ({"num_steps": "a"}, "num_steps must be an integer, got 'a'"),
        ({"num_steps": 1.5}, "num_steps must be an integer, got 1.5"),
        ({"num_steps": True}, "num_steps must be an integer, got True"),
        ({"num_steps": None}, "num_steps must be an integer, got None"),
        ({"gamma": "0.9"}, "gamma must be a number, got '0.9'"),
        ({"clip_vloss": "no"}, "clip_vloss must be True or False, got 'no'"),
        ({"network": 3}, "network must be a text, got 3"),
        ({"memory": []}, r"memory must be none or gru, got \[\]"),
    ],
)
def test_a_setting_of_another_type(words: dict, sentence: str) -> None:
    with pytest.raises(ValueError, match=f"^{sentence}$"):
        PPOConfig(**words)


class Odd(gymnasium.Wrapper):
    """CartPole with something wrong: in its observations, rewards, or in what its functions return."""

    def __init__(self, wrong: str) -> None:
        super().__init__(one())
        self.wrong = wrong

    def reset(self, **words: Any) -> Any:
        seen, info = self.env.reset(**words)
        return seen if self.wrong == "old reset" else (seen, info)

    def step(self, action: Any) -> Any:
        seen, reward, *rest = self.env.step(action)
        if self.wrong == "old step":
            return seen, reward, False, {}
        seen = {"shape": seen[:2], "nan": seen * np.nan}.get(self.wrong, seen)
        if self.wrong == "exit":
            raise SystemExit(3)
        return seen, {"reward": np.inf, "no reward": None}.get(self.wrong, reward), *rest


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ("old reset", "failed in reset"),
        ("old step", "failed in step"),
        ("shape", r"the observation has shape \(2,\), observation_space has \(4,\)"),
        ("nan", "environment 0 returned an observation that is not finite"),
        ("exit", "failed in step: SystemExit: 3"),
        ("reward", "environment 0 returned a reward that is not finite: inf"),
        ("no reward", "failed in step: ValueError: the reward must be a number, got None"),
    ],
)
def test_what_no_environment_may_give(wrong: str, message: str) -> None:
    env = GymUPOMDP(lambda: Odd(wrong), lambda *_: None, {"length": (0.1, 2.0)}, 2)
    with pytest.raises(LevelError, match=message + r".*\(level: theta \[.*'length': .*; seed \d+\)"):
        env.reset(seed=0)
        env.step(np.zeros(2, int))
