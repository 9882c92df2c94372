"""Semi-expert programs: every page is a match, its players run its behaviors, and both engines' rates are reported."""

import json

import numpy as np
import pytest

from lab.benchmarks.__main__ import main
from lab.grf.experts import OURS, Expert, Found, correlations, experts, play_expert, play_experts
from regista.envs.football.config import FootballConfig
from regista.envs.football.constants import BUILTIN_AI, GK, RIGHT
from regista.envs.football.scenic.domain import FOOTBALL
from regista.envs.football.scenic.lineup import Lineup
from regista.envs.football.vector_env import FootballVectorEnv
from regista.minigames.suites import HERE
from scenic_lite import load

NAMES = [each.name for each in experts()]
SIDES = {"11_vs_gk": (11, 1), "avoid_pass_shoot": (3, 2), "pass_and_shoot": (3, 2), "run_to_score": (2, 6)}


def test_every_page_has_a_published_rate():
    pages = {path.stem for path in (HERE / "experts").glob("*.scenic")} - {"skills"}
    assert pages == set(NAMES) and len(NAMES) == 9
    assert sum(each.is_team for each in experts()) == 4
    assert all(0 < each.published < 1 for each in experts())


@pytest.mark.parametrize("name", NAMES)
def test_a_page_is_the_match_that_it_is_named_after(name):
    lineup = Lineup(load(HERE / "experts" / f"{name}.scenic", FOOTBALL), "active")
    teams, roles = np.asarray(lineup.roster.teams), np.asarray(lineup.roster.roles)
    sides = tuple(int((teams == team).sum()) for team in (0, 1))
    assert sides == SIDES.get(name.removeprefix("team_"), (11, 11))
    assert ((teams == RIGHT) & (roles == GK)).sum() == 1
    assert lineup.config.end_episode_on_possession_change and not lineup.config.offsides
    assert lineup.config.game_duration in (200, 400)


def test_one_agent_moves_who_is_his_and_the_ai_the_others():
    """All eleven have the behavior, but it is active in one player at a time."""
    env = FootballVectorEnv(HERE / "experts" / "11_vs_gk.scenic", 8, config=FootballConfig(control="active"))
    env.reset(seed=0)
    for _ in range(60):
        env.step(env.program_actions())
        players = env.matches["players"][:, :11]
        assert ((players["action"] != BUILTIN_AI).sum(1) == 1).all()
    assert (env.matches["ball"]["x"] > 10).mean() > 0.7 and (players["x"][:, 0] < -30).all()


@pytest.mark.slow
def test_a_runner_scores_and_a_team_passes():
    one = Expert("run_to_score", False, 0.4, 100)
    # 85 of 200; 42 of 84 in GRF, whose keeper often slides at the ball and misses it
    assert play_expert(one, OURS, 64).scored.sum() >= 16
    team = play_expert(Expert("team_counterattack", True, 0.4, None), OURS, 8)
    owners = [set(row[row >= 0]) for row in team.owner]
    assert np.mean([len(row) >= 2 for row in owners]) > 0.7


@pytest.mark.slow
def test_rates_and_ranks_are_told_of_both_engines():
    chosen = [each for each in experts() if each.name in ("run_to_score", "team_pass_and_shoot")]
    found = list(play_experts(chosen, OURS, 4))
    assert [each.rates()["published"] for each in found] == [0.4245, 0.51]
    assert "0.42 [0.37, 0.48]" in found[0].line() and found[1].line()[4] == "0.51"  # unknown number of episodes
    alike = [Found(found[0].expert, found[0].ours, found[0].ours), Found(found[1].expert, found[1].ours, found[1].ours)]
    assert correlations(alike)["ours, grf"] in (1.0, pytest.approx(np.nan, nan_ok=True))


@pytest.mark.slow
@pytest.mark.long
def test_the_command_tells_of_all_nine(engine, capsys):
    words = ["--suite", "grf", "--measure", "--family", "experts", "--effort", "0.02", *engine]
    assert main([*words, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["results"]
    assert [each["program"] for each in found["experts"]] == NAMES
    assert set(found["rank_correlations"]) == {"ours, grf", "ours, published", "grf, published"}
