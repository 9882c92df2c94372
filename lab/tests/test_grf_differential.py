"""The randomized differential test: drawn scenes, distances between engines, printed and written results."""

import json
from dataclasses import replace

import numpy as np
import pytest

from lab.benchmarks.__main__ import main
from lab.grf.differential import (
    OURS,
    Pair,
    as_json,
    compare,
    energies,
    energy_table,
    play_scenes,
    worst,
)
from lab.grf.drawn_scenes import STEPS, DrawnScene, draw_scene
from regista.envs.football.constants import GOAL, RUNNING
from regista.experiments.transfer.episodes import Episodes, side_by_side

pytestmark = pytest.mark.slow


def straight(speed, lengths, ended=RUNNING):
    """Return episodes in which the ball and the only player move straight, at speeds [E] in m per step."""
    ball = np.zeros((len(speed), STEPS + 1, 3))
    ball[..., 0] = np.array(speed)[:, None] * np.arange(STEPS + 1)
    count = len(speed)
    return Episodes(
        ball=ball,
        places=ball[:, :, None, :2],
        owner=np.full((count, STEPS + 1), -1),
        actions=np.zeros((count, STEPS), int),
        observations=np.zeros((count, STEPS, 0)),
        lengths=np.array(lengths),
        ended=np.full(count, ended),
        score=np.tile([int(ended == GOAL), 0], (count, 1)),
        returns=np.zeros(count),
    )


def test_a_scene_can_be_had_again_by_its_name():
    first, again, other = draw_scene("3:7"), draw_scene("3:7"), draw_scene("3:8")
    assert first.scene == again.scene and (first.keys == again.keys).all()
    assert first.scene != other.scene
    with pytest.raises(ValueError, match="SEED:NUMBER"):
        draw_scene("three")


def test_scenes_have_two_to_eleven_players_a_side_on_the_pitch():
    drawn = [draw_scene(f"0:{number}") for number in range(300)]
    for team in ("left", "right"):
        sizes = [len(getattr(each.scene, team)) for each in drawn]
        assert min(sizes) == 2 and max(sizes) == 11
    places = np.array([place for each in drawn for _, *place in (*each.scene.left[1:], *each.scene.right[1:])])
    assert np.abs(places[:, 0]).max() <= 0.95 and np.abs(places[:, 1]).max() <= 0.38
    keys = np.concatenate([each.keys for each in drawn])
    assert set(keys) == set(range(19)) and all(len(each.keys) == STEPS for each in drawn)


def test_distances_are_means_over_pairs_that_both_go_on():
    pair = Pair(draw_scene("0:0"), straight([0.1, 0.1], [60, 60]), straight([0.1, 0.3], [60, 60]))
    assert pair.apart(10, "ball") == pytest.approx(1.0)  # mean of 0, 2, 0, 2 m
    assert pair.apart(10, "ball", limit=True) == pytest.approx(2.0)  # mean of the two different pairs alone
    assert pair.apart(40, "players") == pytest.approx(4.0)
    short = Pair(draw_scene("0:0"), straight([0.1, 0.1], [60, 60]), straight([0.1, 0.3], [60, 15]))
    assert short.apart(20, "ball") == pytest.approx(0.0) and np.isnan(short.apart(20, "ball", limit=True))
    assert short.line()[2] == "0.0 (over)"


def test_each_scene_has_seeds_of_its_own_in_each_engine():
    scenes = [draw_scene(f"0:{number}") for number in range(30)]
    drawn = [scene.seeds(engine, 4) for scene in scenes for engine in (1, 2)]
    assert len({int(seed) for seeds in drawn for seed in seeds}) == 240
    assert (draw_scene("0:7").seeds(2, 4) == drawn[15]).all()


def test_energy_distance_is_what_both_are_apart_beyond_their_own_spread():
    def pair(number, ours, grf, lengths=(60, 60)):
        return Pair(draw_scene(f"0:{number}"), straight(ours, lengths), straight(grf, lengths))

    alike, apart = pair(0, [0.1, 0.3], [0.1, 0.3]), pair(1, [0.1, 0.3], [0.4, 0.6])
    assert apart.energy(10, "ball") == pytest.approx(3.0 - 0.5 * (2.0 + 2.0))
    assert alike.energy(10, "players") == pytest.approx(1.0 - 2.0)  # unbiased over scenes, noisy for two episodes
    assert pair(2, [0.2, 0.2], [0.1, 0.3]).energy(10, "ball") == pytest.approx(0.0)  # playing the mean gains nothing
    mean, error = energies([alike, apart, pair(3, [0.1, 0.3], [0.4, 0.6], (60, 5))])["ball_10"]
    assert mean == pytest.approx(0.0) and error == pytest.approx(1.0)  # the third pair has too few long episodes
    assert energy_table([alike, apart])[1][:2] == ["ball", "0.00 ± 1.00"]


def test_energy_distance_of_the_same_draws_is_nought_on_average():
    rng = np.random.default_rng(0)
    scene = draw_scene("0:0")
    pairs = [Pair(scene, *(straight(rng.normal(1.0, 0.1, 4), [60] * 4) for _ in range(2))) for _ in range(400)]
    mean, error = energies(pairs)["ball_20"]
    assert abs(mean) < 3 * error < 0.3


def test_endings_agree_by_pairs_and_the_worst_scene_comes_first():
    alike = Pair(draw_scene("0:0"), straight([0.1, 0.1], [60, 60]), straight([0.1, 0.1], [60, 60]))
    unlike = Pair(draw_scene("0:1"), straight([0.1, 0.1], [60, 60]), straight([0.1, 0.1], [60, 60], GOAL))
    assert alike.agreement() == 1.0 and unlike.agreement() == 0.0 and unlike.agreement(limit=True) == 1.0
    assert [pair.drawn.name for pair in worst([alike, unlike])] == ["0:1", "0:0"]
    rows = {row.name: row for row in compare([alike, unlike])}
    assert rows["endings that agree"].ours == 0.5 and not rows["endings that agree"].ok
    assert rows["ball apart at step 20"].ok
    assert as_json([alike, unlike])[0]["endings_grf"] == {"scored": 2}


def test_two_engines_part_where_somebody_is_farther_away_than_a_stride():
    ours, grf = straight([0.1], [60]), straight([0.3], [50], GOAL)
    painter = Pair(draw_scene("0:0"), ours, grf).painter()
    seen = side_by_side("n", painter, ours, grf, 0)
    assert seen.parted() == 8 and len(seen.points[1]) == 51
    assert "step 8" in seen.card() and "scored" in seen.card()
    assert side_by_side("n", painter, ours, ours, 0).parted() is None


def test_our_simulator_is_as_far_from_itself_as_it_is_from_itself():
    (pair,) = play_scenes([draw_scene("0:2")], OURS, seeds=3)
    assert (pair.ours.ball[:, 0] == pair.grf.ball[:, 0]).all()
    assert pair.apart(10, "players") < 1.0


def test_seeds_of_a_scene_are_those_that_are_played(monkeypatch):
    seen = []
    monkeypatch.setattr("lab.grf.differential.play_keys", lambda env, keys, levels: seen.append(levels["seed"]))
    list(play_scenes([draw_scene("0:2"), draw_scene("0:3")], OURS, seeds=2))
    assert len(set(np.concatenate(seen).tolist())) == 8


def test_the_command_prints_json_and_writes_the_worst(engine, capsys, tmp_path):
    words = ["--suite", "grf", "--measure", "--scenes", "0:0", "0:3", *engine]
    assert main([*words, "--json", "--figures", str(tmp_path / "out")]) == 0
    found = json.loads(capsys.readouterr().out)["results"]
    assert {each["scene"] for each in found["scenes"]} == {"0:0", "0:3"}
    assert len(found["differential"]) == 7 and set(found["energy"]) >= {"ball_10", "players_40"}
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        *("differential.png", "worst.rrd", "0-0.scenic", "0-3.scenic")
    }


def test_without_the_real_engine_it_says_so(capsys, tmp_path):
    assert main(["--suite", "grf", "--measure", "--grf-python", str(tmp_path / "none")]) == 1
    assert "make grf" in capsys.readouterr().err
    assert main(["--suite", "grf", "--measure", "--scenes", "three"]) == 2
    assert "SEED:NUMBER" in capsys.readouterr().err


def test_a_drawn_scene_knows_its_sides():
    drawn = draw_scene("0:0")
    assert DrawnScene("n", replace(drawn.scene, right=()), drawn.keys).sides == f"{len(drawn.scene.left)} v 0"
