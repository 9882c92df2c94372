"""Records and replays: bit for bit, and a clear word about what is no record."""

from __future__ import annotations

import numpy as np
import pytest

from regista import minigames
from regista.envs.football.config import FootballConfig
from regista.envs.football.replay import Recorder, RecordError, load_record, replay, same
from regista.envs.football.vector_env import FootballVectorEnv

PROGRAM = minigames.MINIGAMES["3v2FourBehaviors"].program  # with behaviors, and a module of its own
ALONE = "ego = LeftCM at 0 @ 0\nRightGK at 99 @ 0\nball = Ball at Range(1, 3) @ 0\n"


def recorded(path, program, steps=120, **settings):
    env = FootballVectorEnv(program, 3, config=FootballConfig(**settings))
    env.reset(seed=8)
    rng = np.random.default_rng(0)
    for _ in range(5):
        env.step(rng.integers(0, 19, env.action_space.shape))
    recorder = Recorder(env)
    course = [env.matches]
    for _ in range(steps):
        recorder.step(rng.integers(0, 19, env.action_space.shape))
        course.append(env.matches)
    recorder.save(path)
    return course


@pytest.mark.slow
@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("program", "settings"),
    [(PROGRAM, {"representation": "smm_stacked", "control": "closest2"}), (ALONE, {"rewards": "scoring,checkpoints"})],
)
def test_a_record_plays_again_bit_for_bit(tmp_path, program, settings):
    course = recorded(tmp_path / "match.npz", program, **settings)
    again = list(replay(tmp_path / "match.npz"))
    assert len(again) == len(course)
    assert all(same(one, two) for one, two in zip(course, again, strict=True))


def test_a_film_of_a_replay_ends_with_the_end(tmp_path):
    course = recorded(tmp_path / "match.npz", ALONE.replace("Range(1, 3)", "2") + "param game_duration = 30\n", 40)
    again = list(replay(tmp_path / "match.npz", endings=True))
    assert [int(matches["step"][0]) for matches in again] == [*range(5, 31), *range(1, 16)]
    assert [int(matches["step"][0]) for matches in course] == [*range(5, 30), *range(16)]


def test_a_record_of_single_episodes_stands_still_at_their_ends(tmp_path):
    env = FootballVectorEnv(ALONE + "param game_duration = DiscreteRange(5, 20)\n", 3)
    env.reset(seed=1)
    recorder, over = Recorder(env), np.zeros(3, bool)
    while not over.all():
        _, _, terminated, truncated, _ = recorder.advance(np.full(3, 5))
        over |= terminated | truncated
    recorder.save(tmp_path / "match.npz")
    *_, last = replay(tmp_path / "match.npz", endings=True)
    assert same(last, env.matches) and len(set(load_record(tmp_path / "match.npz").lengths.tolist())) > 1


@pytest.mark.slow
@pytest.mark.parametrize("control", ["closest1", "all"])
def test_a_program_that_plays_for_the_agents_does_so_in_the_replay(tmp_path, control):
    env = FootballVectorEnv(PROGRAM, 2, config=FootballConfig(control=control))
    env.reset(seed=1)
    scripted = env.with_scripted_policy()
    recorder, course, actions = Recorder(scripted), [scripted.matches], []
    for _ in range(40):
        actions.append(recorder.step(np.zeros(scripted.action_space.shape, int))[4]["agent_actions"])
        course.append(scripted.matches)
    recorder.save(tmp_path / "match.npz")
    record = load_record(tmp_path / "match.npz")
    assert record.scripted and (record.actions.reshape(40, 2, -1) == actions).all() and (record.actions > 0).any()
    assert all(same(*pair) for pair in zip(course, replay(record), strict=True))


def test_a_record_has_whole_matches_or_single_episodes():
    for first, second in (("step", "advance"), ("advance", "step")):
        env = FootballVectorEnv(ALONE, 1)
        env.reset(seed=0)
        recorder = Recorder(env)
        getattr(recorder, first)(np.zeros(1, int))
        with pytest.raises(ValueError, match="a record holds whole matches"):
            getattr(recorder, second)(np.zeros(1, int))


def test_foreign_and_damaged_files_are_refused(tmp_path):
    recorded(tmp_path / "match.npz", ALONE, 20)
    data = (tmp_path / "match.npz").read_bytes()
    for name, content in (("cut", data[: len(data) // 2]), ("text", b"hello"), ("empty", b"")):
        (tmp_path / f"{name}.npz").write_bytes(content)
        with pytest.raises(RecordError, match=f"{name}.npz is not a record of a match"):
            load_record(tmp_path / f"{name}.npz")
    np.savez(tmp_path / "other.npz", a=np.arange(3))
    with pytest.raises(RecordError, match="its format is not 'regista match record'"):
        load_record(tmp_path / "other.npz")
    with pytest.raises(FileNotFoundError):
        load_record(tmp_path / "none.npz")


def changed(tmp_path, **changes):
    """Return a record in which some of what it holds is another."""
    recorded(tmp_path / "match.npz", ALONE, 20)
    with np.load(tmp_path / "match.npz") as archive:
        parts = {name: archive[name] for name in archive.files}
    for name, change in changes.items():
        parts[name] = change(parts[name])
    np.savez(tmp_path / "changed.npz", **parts)
    return tmp_path / "changed.npz"


def test_a_replay_that_comes_out_differently_says_so(tmp_path):
    path = changed(tmp_path, actions=lambda actions: np.full_like(actions, 5))
    with pytest.raises(RecordError, match="differ from the recorded ones"):
        list(replay(path))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"actions": lambda a: a + 100}, "the record is damaged: action 1"),
        ({"last": lambda a: a["step"]}, "by another version of the code: its matches have other fields"),
        ({"simulator": lambda a: a + 1}, "changed.npz was recorded on simulator version 2; version 1 cannot replay it"),
        ({"program": lambda a: "ego = LeftCM at"}, "cannot load the record's program"),
        (
            {"program": lambda a: str(a) + "LeftGK at -99 @ 0\n"},
            "cannot load the record's program|differ from the recorded ones",
        ),
        ({"config": lambda a: "{"}, "is damaged"),
        ({"config": lambda a: '{"color": 1}'}, "is damaged"),
    ],
)
def test_what_is_wrong_in_a_record_is_named(tmp_path, changes, message):
    with pytest.raises(RecordError, match=message):
        list(replay(changed(tmp_path, **changes)))


def test_matches_that_were_never_reset_cannot_be_recorded():
    with pytest.raises(ValueError, match=r"call env\.reset\(\) before Recorder\(env\)"):
        Recorder(FootballVectorEnv(ALONE, 2))


def test_matches_that_draw_their_own_levels_cannot_be_recorded():
    env = FootballVectorEnv(ALONE, 1)
    env.reset(seed=0)
    env.level_sampler = env.sample_levels
    with pytest.raises(ValueError, match="level_sampler = None"):
        Recorder(env)
