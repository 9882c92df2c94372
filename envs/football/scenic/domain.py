"""Football as a domain of the language: the `.scenic` file of each importable name.

The names of Scenic4RL (`scenic.simulators.gfootball...`) are aliases, so that programs written for it run unchanged.
Read next: `library/model.scenic`.
"""

from pathlib import Path

from regista.envs.football.scenic.world import FOOTBALL_WORLD
from regista.envs.football.state import ENGINE_FIELDS
from scenic_lite.core.world import Domain

LIBRARY = Path(__file__).parent / "library"
MODULES = {name: LIBRARY / f"{name}.scenic" for name in ("model", "actions", "behaviors", "simulator", "constants")}
PACKAGES = ("football", "scenic.simulators.gfootball")
ELSEWHERE = {"utilities": "constants", "utilities.constants": "constants"}  # Scenic4RL's other modules

# Parameters by which the engine differs from the measured one; random ones are columns of θ.
FACTORS = frozenset({name for name, *_ in ENGINE_FIELDS})

# Parameters that are settings of the match. All may be random except `ONE_FOR_ALL`, which all matches share.
SETTINGS = FACTORS | frozenset(
    {
        "engine_spread",
        *("game_duration", "second_half", "deterministic", "offsides", "use_magnet", "defending", "agents_only"),
        *("left_team_difficulty", "right_team_difficulty"),
        *("end_episode_on_score", "end_episode_on_out_of_play", "end_episode_on_possession_change"),
    }
)

ONE_FOR_ALL = frozenset({"defending"})

# Parameters with which Scenic4RL's programs configure its engine, pictures and log files: accepted and ignored.
ENGINE = frozenset(
    {
        *("action_set", "custom_display_stats", "display_game_stats", "dump_frequency", "dump_full_episodes"),
        *("dump_scores", "game_engine_random_seed", "logdir", "manual_control", "physics_steps_per_frame", "players"),
        *("real_time", "render_resolution_x", "render_resolution_y", "rewards", "stacked", "tracesdir"),
        *("video_format", "video_quality_level", "write_full_episode_dumps", "write_goal_dumps", "write_video"),
    }
)

FOOTBALL = Domain(
    name="football",
    library={f"{package}.{name}": path for package in PACKAGES for name, path in MODULES.items()}
    | {f"scenic.simulators.gfootball.{name}": MODULES[meant] for name, meant in ELSEWHERE.items()}
    | dict.fromkeys(PACKAGES, LIBRARY / "football.scenic"),
    default_model="football.behaviors",  # it imports the model and the actions
    params=SETTINGS | ENGINE,
    world=FOOTBALL_WORLD,
)
