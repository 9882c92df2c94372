"""Tests of the examples: each runs unchanged for a few seconds, in this process, which has already imported torch."""

import runpy
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
SHORT = {
    "cleanrl_style.py": ["--env-steps", "4096"],
    "with_stable_baselines3.py": ["--env-steps", "2048"],
    "choose_among_skills.py": ["--env-steps", "8192"],
    "with_torchrl.py": ["--env-steps", "512"],
    "maze.py": ["--env-steps", "8192"],
    "own_levels.py": ["--env-steps", "4096"],
    "multiroom.py": ["--env-steps", "4096"],
    "hopper.py": ["--env-steps", "4096", "--out", "run"],
    "highway.py": ["--env-steps", "512", "--out", "run"],
    "roads.py": ["--env-steps", "512", "--out", "run"],
    "with_rllib.py": ["--env-steps", "2048"],
    "driving.py": ["--env-steps", "512", "--out", "run"],
}
SAYS = {
    "cleanrl_style.py": "buffer",
    "with_stable_baselines3.py": "alp/components",
    "choose_among_skills.py": "ChoosePassing",
    "with_torchrl.py": "512 env_steps",
    "maze.py": "PerfectMazeMedium",
    "own_levels.py": "4096 env_steps",
    "multiroom.py": "of 100 solved",
    "hopper.py": "mars, loaded",
    "highway.py": "rush hour",
    "roads.py": "tight and busy",
    "with_rllib.py": "env_steps, mean return",
    "driving.py": "sudden",
}


NEEDS = {
    "multiroom.py": "minigrid",
    "hopper.py": "mujoco",
    "highway.py": "highway_env",
    "roads.py": "metadrive",
    "with_rllib.py": "ray.rllib",
    "driving.py": "scenic",
}


@pytest.mark.slow
@pytest.mark.sample(2)
@pytest.mark.parametrize("name", SHORT)
def test_an_example_runs(name, tmp_path, monkeypatch, capsys):
    if name in NEEDS:
        package = pytest.importorskip(NEEDS[name], reason=f"the example needs {NEEDS[name]}")
        if name == "roads.py" and not (Path(package.__file__).parent / "assets" / "version.txt").exists():
            pytest.skip("the example needs MetaDrive's assets, which it fetches when it is first used")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", [name, *SHORT[name]])
    runpy.run_path(str(ROOT / "examples" / name), run_name="__main__")
    assert SAYS[name] in capsys.readouterr().out
