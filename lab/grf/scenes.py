"""The academy scenes and lineups of Google Research Football: positions of players at the start of an episode.

Positions are those of scenario files, with the right team in its own mirrored frame; `stage_scene` moves them to where
the engine puts players. Read next: `grf.policies`, who plays in them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from lab.grf.stage import Stage
from regista.envs.football.constants import CB, CF, CM, GK, LB, LM, RB, RM
from regista.envs.football.kick_off import MatchConfig, Roster
from regista.envs.football.physics.motion import take_stance
from regista.kernels.jit import kernel

Players = tuple[tuple[int, float, float], ...]  # role, x, y

KEEPER = (GK, -1.0, 0.0)
FAR_KEEPER = (GK, 1.0, 0.0)  # on the wrong goal line: an empty goal
STRETCH = (55.0 / 54.4, 36.0 * 2.36 / 83.6)  # of players' positions, as in the engine; the ball stays

BACKS = ((LB, -0.422, -0.19576), (CB, -0.5, -0.06356), (CB, -0.5, 0.063559), (RB, -0.422, 0.19576))
MIDDLE = ((CM, -0.184212, -0.10568), (CM, -0.267574, 0.0), (CM, -0.184212, 0.10568))
KICKING_OFF = (KEEPER, (RM, 0.0, 0.02), (CF, 0.0, -0.02), *BACKS, *MIDDLE, (LM, -0.01, -0.216102))
WAITING = (KEEPER, (RM, -0.05, 0.0), (CF, -0.01, 0.216102), *BACKS, *MIDDLE, (LM, -0.01, -0.216102))


@dataclass(frozen=True)
class Scene:
    """One scene: both teams, the ball, and the number of steps of an episode."""

    left: Players
    right: Players
    ball: tuple[float, float]
    duration: int = 400


CHASERS = ((LB, 0.12, 0.2), (CB, 0.12, 0.1), (CM, 0.12, 0.0), (CB, 0.12, -0.1), (RB, 0.12, -0.2))
COUNTER_LEFT = (
    KEEPER,
    *((LB, -0.672, -0.19576), (CB, -0.75, -0.06356), (CB, -0.75, 0.063559), (RB, -0.672, 0.19576)),
    *((CM, -0.434, -0.10568), (CM, -0.434, 0.10568), (CM, 0.5, -0.3161), (LM, 0.25, -0.1), (RM, 0.25, 0.1)),
    (CF, 0.35, 0.316102),
)
COUNTER_RIGHT = (
    KEEPER,
    *((LB, 0.128, -0.19576), (CB, 0.4, -0.06356), (CB, -0.4, 0.063559), (RB, 0.128, -0.19576)),
    *((CM, 0.365, -0.10568), (CM, 0.282, 0.0), (CM, 0.365, 0.10568), (LM, 0.54, -0.3161), (RM, 0.51, 0.0)),
    (CF, 0.54, 0.316102),
)
SCENES = {
    "empty_goal_close": Scene((KEEPER, (CB, 0.75, 0.0)), (FAR_KEEPER,), (0.77, 0.0)),
    "empty_goal": Scene((KEEPER, (CB, 0.0, 0.0)), (FAR_KEEPER,), (0.02, 0.0)),
    "run_to_score": Scene((KEEPER, (CB, 0.0, 0.0)), (FAR_KEEPER, *CHASERS), (0.02, 0.0)),
    "run_to_score_with_keeper": Scene((KEEPER, (CB, 0.0, 0.0)), (KEEPER, *CHASERS), (0.02, 0.0)),
    "pass_and_shoot_with_keeper": Scene(
        (KEEPER, (CB, 0.7, 0.0), (CB, 0.7, -0.3)), (KEEPER, (CB, -0.75, 0.3)), (0.7, -0.28)
    ),
    "run_pass_and_shoot_with_keeper": Scene(
        (KEEPER, (CB, 0.7, 0.0), (CB, 0.7, -0.3)), (KEEPER, (CB, -0.75, 0.1)), (0.7, -0.28)
    ),
    "3_vs_1_with_keeper": Scene(
        (KEEPER, (CM, 0.6, 0.0), (CM, 0.7, 0.2), (CM, 0.7, -0.2)), (KEEPER, (CB, -0.75, 0.0)), (0.62, 0.0)
    ),
    "counterattack_easy": Scene(COUNTER_LEFT, COUNTER_RIGHT, (0.26, -0.11)),
    "11_vs_11": Scene(KICKING_OFF, WAITING, (0.0, 0.0), duration=3000),
}


def stage_scene(name: str, config: MatchConfig, n: int, seed: int = 0) -> Stage:
    """Set up n matches of a scene, with these settings except for the scene's own duration."""
    scene = SCENES[name]
    players = (*scene.left, *scene.right)
    roster = Roster([0] * len(scene.left) + [1] * len(scene.right), [role for role, _, _ in players])
    places = np.array([(x, y) for _, x, y in players]) * STRETCH
    settings = replace(config, game_duration=scene.duration)
    stage = Stage(places, scene.ball, roster, settings, n, seed, mirrored=True)
    take_stances(stage.matches)
    return stage


@kernel
def take_stances(matches):
    """Give bodies individual stances before the first whistle of every match, as in an environment."""
    for e in range(len(matches)):
        take_stance(matches[e])
