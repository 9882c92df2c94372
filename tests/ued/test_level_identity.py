"""A level is what was scored: every episode of it starts from the same layout, on every student and at every visit.

The luck of an episode is the same for all students of a visit, and new in the next one. Asked of all methods on all
adapters, through a kill and a resume.
"""

import hashlib
import pickle
from collections import defaultdict
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import Box, Discrete

import ued
from ued.adapters.gym import GymUPOMDP
from ued.adapters.mixture import Mixture
from ued.core.parameters import Column, Range
from ued.core.upomdp import UPOMDP
from ued.methods import METHODS

PPO = ued.PPOConfig(num_steps=24, num_minibatches=1, update_epochs=1, hidden_size=8)
BUFFER = ued.BufferConfig(capacity=12)
SETTINGS = {
    "minimax": ued.MinimaxConfig(adversary=ued.AdversaryConfig(min_batch=4)),
    "paired": ued.PairedConfig(adversary=ued.AdversaryConfig(min_batch=4)),
    "repaired": ued.RepairedConfig(adversary=ued.AdversaryConfig(min_batch=4), buffer=BUFFER),
    "plr": ued.PLRConfig(buffer=BUFFER, episodes_per_level=2),
    "robust_plr": ued.PLRConfig(buffer=BUFFER),
    "accel": ued.ACCELConfig(buffer=BUFFER),
    "cenie": ued.CENIEConfig(buffer=BUFFER),
    "sfl": ued.SFLConfig(candidates=6, candidate_episodes=2, chosen=3, choose_every=2),
}


class Rooms(gymnasium.Env):
    """Draws its rooms when it is reset, its weather from a second seed, and chance while it is played."""

    observation_space, action_space = Box(0, 1, (4,), np.float32), Discrete(2)
    rooms = 1

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.t, self.luck = 0, (options or {}).get("weather")
        self.layout = self.np_random.random(int(self.rooms) + 2)
        return self._observe(), {}

    def step(self, action):
        self.t += 1
        chance = self.np_random.random()
        return self._observe(), float(chance < 0.5) * action, self.t >= 3 + 2 * int(action), False, {}

    def _observe(self):
        return np.array([*self.layout[:3], self.t / 10], np.float32)


def put(env, values):
    env.unwrapped.rooms = values["rooms"]


class Track(UPOMDP):
    """A native batch: the track is drawn from the level's seed, the wind from the episode's luck."""

    def __init__(self, num_envs=4):
        super().__init__(num_envs, Box(-9, 9, (3,), np.float32), Discrete(2), [Column("bend", Range(0, 1))])
        self.track, self.wind, self.t = np.zeros((num_envs, 2)), np.zeros(num_envs), np.zeros(num_envs, int)

    def _start(self, levels, where):
        for index, level, luck in zip(where, levels, self.luck_seeds(where), strict=True):
            self.track[index] = np.random.default_rng(int(level["seed"])).random(2) + level["theta"][0]
            self.wind[index], self.t[index] = np.random.default_rng(int(luck)).random(), 0
        return self._observe()

    def _advance(self, actions):
        self.t += 1
        ended = self.t >= 3 + np.asarray(actions)
        return self._observe(), (self.wind > 0.5).astype(float), ended, np.zeros_like(ended), {}

    def _observe(self):
        return np.column_stack([self.track, self.t]).astype(np.float32)

    def get_state(self):
        return {**self.level_state(), "track": self.track.copy(), "wind": self.wind.copy(), "t": self.t.copy()}

    def set_state(self, state):
        self.set_level_state(state, "track", "wind", "t")
        self.track[:], self.wind[:], self.t[:] = state["track"], state["wind"], state["t"]
        return self._observe()

    def copy(self):
        twin = Track(self.num_envs)
        twin.set_state(self.get_state())
        return twin


def rooms(num_envs=4, luck="weather", vectorization="sync"):
    return GymUPOMDP(Rooms, put, {"rooms": ued.Integer(1, 6)}, num_envs, vectorization, luck=luck)


def seeds(num_envs=4):
    return GymUPOMDP(Rooms, None, ued.Seeds(9), num_envs, luck="weather")


def mixture(num_envs=4):
    return Mixture([rooms(num_envs), seeds(num_envs)], ["rooms", "seeds"])


def football(num_envs=4):
    from regista.envs.football.config import FootballConfig
    from regista.envs.football.vector_env import FootballVectorEnv
    from regista.minigames import MINIGAMES

    return FootballVectorEnv(str(MINIGAMES["1v1Restricted"].program), num_envs, config=FootballConfig())


ADAPTERS = {
    "gymnasium": rooms,
    "async": lambda: rooms(2, vectorization="async"),
    "seeds": seeds,
    "native": Track,
    "mixture": mixture,
    "football": football,
}
QUICK = [(method, adapter) for method in ("dr", "plr", "paired") for adapter in ("gymnasium", "native")]
LONG = [(method, "async") for method in METHODS if method not in ("plr", "paired")]  # a process for each environment
CASES = [
    pytest.param(
        method,
        adapter,
        marks=[pytest.mark.slow] * ((method, adapter) not in QUICK) + [pytest.mark.long] * ((method, adapter) in LONG),
    )
    for method in METHODS
    for adapter in ADAPTERS
]


class Start(NamedTuple):
    """How an episode began."""

    student: int
    visit: int
    episode: int
    luck: int
    layout: str


class Watch:
    """Notes how each episode begins in the environments of all learners of a method, by level."""

    def __init__(self):
        self.starts = defaultdict(list)

    def over(self, method):
        for student, learner in enumerate(method.learners):
            self._over_one(student, learner.worker.upomdp)

    def _over_one(self, student, upomdp):
        start = upomdp._start
        again = upomdp.play_again

        def note(where, seen):
            for index, luck in zip(where.tolist(), upomdp.luck_seeds(where).tolist(), strict=True):
                key = upomdp.key_of(upomdp.levels[index])
                numbers = student, int(upomdp.visits[index]), int(upomdp.episodes[index]), luck
                self.starts[key].append(Start(*numbers, layout(upomdp, index, seen)))

        def watched_start(levels, where):
            seen = start(levels, where)
            note(where, seen)
            return seen

        def watched_again(where=None):
            seen = again(where)
            if type(upomdp).play_again is not UPOMDP.play_again:  # which does not call `_start`
                note(np.flatnonzero(upomdp._mask(where)), seen)
            return seen

        upomdp._start, upomdp.play_again = watched_start, watched_again


def layout(upomdp, index, seen):
    """Return a digest of all that an episode starts from, but for its luck."""
    parts = [np.asarray(seen[index]).tobytes()]
    if isinstance(upomdp, GymUPOMDP) and upomdp.vectorization == "sync":
        env = upomdp.vector.envs[index].unwrapped
        state = {name: value for name, value in vars(env).items() if name != "luck"}
        parts.append(pickle.dumps(state))
        assert env.luck == int(upomdp.luck_seeds(np.array([index]))[0])
    if hasattr(upomdp, "matches"):  # of football: the stance in which the whistle finds a player is luck
        players = upomdp.matches[index]["players"]
        parts = [players[name].tobytes() for name in ("x", "y", "role", "team")]
    return hashlib.sha256(b"".join(parts)).hexdigest()


@cache
def trained(method, adapter, updates=6):
    """Train, kill half-way and resume in environments of its own; return how all episodes began."""
    watch, settings = Watch(), SETTINGS.get(method)
    ppo = replace(PPO, num_steps=256) if adapter == "football" else PPO  # whose episodes are longer
    first = METHODS[method].load()(ADAPTERS[adapter](), ppo, settings, seed=3)
    watch.over(first)
    for _ in range(updates):
        first.update()
    state = pickle.loads(pickle.dumps(first.state_dict(episodes=first.upomdp.supports_state)))
    second = METHODS[method].load()(ADAPTERS[adapter](), ppo, settings, seed=3)
    watch.over(second)
    second.load_state_dict(state)
    for _ in range(updates):
        second.update()
    for each in (first, second):
        for learner in each.learners:
            learner.worker.upomdp.close()
    return watch.starts


@pytest.mark.slow
@pytest.mark.sample(2)
@pytest.mark.parametrize(("method", "adapter"), CASES)
def test_every_episode_of_a_level_starts_alike(method, adapter):
    starts = trained(method, adapter)
    assert all(len({start.layout for start in of_level}) == 1 for of_level in starts.values())
    replayed = max(len({start.visit for start in of_level}) for of_level in starts.values())
    if method in ("plr", "robust_plr", "accel", "cenie", "sfl", "repaired"):
        assert replayed > 2, "no level was visited again, so that this test says nothing"


@pytest.mark.slow
@pytest.mark.sample(10)
@pytest.mark.parametrize(("method", "adapter"), CASES)
def test_luck_is_the_same_for_all_students_and_new_otherwise(method, adapter):
    starts, episodes, students = trained(method, adapter), 0, 0
    for of_level in starts.values():
        lucks = defaultdict(set)
        for start in of_level:
            lucks[start.visit, start.episode].add(start.luck)
            episodes, students = max(episodes, start.episode), max(students, start.student)
        assert all(len(luck) == 1 for luck in lucks.values())
        assert len(set.union(*lucks.values())) == len(lucks), "an episode has the luck of another"
    if method in ("paired", "paired_literal", "repaired"):
        assert students == 1 and episodes >= 1


@pytest.mark.slow
def test_an_edited_level_keeps_the_seed_of_its_parent():
    method = METHODS["accel"].load()(rooms(), PPO, SETTINGS["accel"], seed=0)
    parents, children = {}, []
    for _ in range(12):
        method.update()
        for record in method.last.records:
            parents[int(record["id"])] = record["level"].copy()
            children += [record.copy()] if record["parent"] >= 0 else []
    known = [child for child in children if int(child["parent"]) in parents]
    assert known
    for child in known:
        parent = parents[int(child["parent"])]
        assert child["level"]["seed"] == parent["seed"] and (child["level"]["theta"] != parent["theta"]).any()


@pytest.mark.slow
def test_a_buffer_tells_levels_of_one_theta_apart_by_their_layouts():
    method = METHODS["plr"].load()(rooms(), PPO, ued.PLRConfig(buffer=ued.BufferConfig(capacity=64)), seed=0)
    for _ in range(12):
        method.update()
    levels = method.buffer.slots["level"]
    assert len(np.unique(levels["seed"])) == len(levels) > len(np.unique(levels["theta"]))
    luck = GymUPOMDP(Rooms, put, {"rooms": ued.Integer(1, 6)}, 4, luck=True)
    method = METHODS["plr"].load()(luck, PPO, ued.PLRConfig(buffer=ued.BufferConfig(capacity=64)), seed=0)
    for _ in range(12):
        method.update()
    assert len(method.buffer) == 6
