"""The football programs of the repository: all programs, those with dynamic parts, and the modules that they import.

The tables below classify the files; nothing is derived from their text. `tests/envs/test_reference_match.py` loads all
files and checks the tables. Read next: `tests/envs/reference_match.py`.
"""

from pathlib import Path

ROOT = Path(__file__).parents[1]
FOLDERS = ("lab/benchmarks/programs", "minigames", "tests/programs")
MODULES = {
    "academy/places", "buildup/defenders", "defense/attacks", "experts/skills", "gauntlet/guards", "grf/episode",
    "offense/episode", "offense/offside", "one_v_one/places", "three_v_two/strategies",
}  # fmt: skip
# Folders and programs without behaviors, monitors, temporal requirements and conditions that end a match.
STILL = {
    "academy", "choose_passing", "crossing", "grf", "one_v_one",
    "defense/gk_vs_opponent", "defense/gk_vs_opponent_test", "defense/hesitant_dribble",
    "defense/hesitant_dribble_test", "offense/11_vs_gk", "offense/11_vs_gk_test", "offense/avoid_pass_shoot",
    "offense/avoid_pass_shoot_test", "offense/easy_crossing", "offense/easy_crossing_test", "offense/hard_crossing",
    "offense/hard_crossing_test", "programs/crowd", "programs/eleven_a_side", "programs/figure_4_1",
    "programs/figure_4_3", "programs/football_22", "programs/football_6", "programs/mutated", "programs/polygons",
    "programs/soft", "programs/tight",
}  # fmt: skip


def name_of(path: Path) -> str:
    """Return a file's name in these tables and in the ids of tests."""
    return f"{path.parent.name}/{path.stem}"


FILES = sorted(path for folder in FOLDERS for path in (ROOT / folder).rglob("*.scenic"))
PROGRAMS = [path for path in FILES if name_of(path) not in MODULES]
DYNAMIC = [path for path in PROGRAMS if not {path.parent.name, name_of(path)} & STILL]
