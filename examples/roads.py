"""A driving task in a physics engine: MetaDrive's car on bends; the parameters are radius, lanes and traffic.

    regista train examples/roads.py:roads --method plr --num-envs 4
    regista inspect examples/roads.py:roads

It requires `pip install metadrive-simulator`, which downloads 100 MB of assets at its first use. A process can hold one
simulation only, so each environment runs in its own process. A MetaDrive seed is the index of a scenario (the positions
of the other cars), so `seed_episodes` maps a level's seed to such an index.
"""

import argparse
from pathlib import Path
from typing import Any

import gymnasium

import ued

SCENARIOS = 1000  # number of placements of the other cars


class Arrival(gymnasium.Wrapper):
    """Reports success if the car arrives, for any return; `reset` drops `options`, which MetaDrive rejects."""

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        return self.env.reset(seed=seed)

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        observation, reward, terminated, truncated, info = self.env.step(action)
        return observation, reward, terminated, truncated, {"success": info["arrive_dest"]}


def road() -> gymnasium.Env:
    """Make one environment."""
    from metadrive.envs.metadrive_env import MetaDriveEnv

    quiet = {"log_level": 50, "num_scenarios": SCENARIOS, "store_map": False}  # each episode builds its road
    return Arrival(MetaDriveEnv({**quiet, "map_config": {"type": "pg_map_file", "config": []}, "horizon": 400}))


def put(env: gymnasium.Env, values: dict[str, Any]) -> None:
    """Apply one level to an environment: a straight road, a bend to the left, a bend to the right."""
    bend = {"id": "C", "pre_block_socket_index": 0, "length": 30.0, "radius": values["radius"], "angle": 90.0}
    straight = {"id": "S", "pre_block_socket_index": 0, "length": 40.0}
    config = env.unwrapped.config  # type: ignore[attr-defined]
    config["map_config"]["lane_num"] = values["lanes"]
    config["map_config"]["config"] = [{}, straight, {**bend, "dir": 0}, {**bend, "dir": 1}]
    config["traffic_density"] = values["traffic"]


def scenario(seed: int) -> int:
    """Return the index of a scenario for a level's seed."""
    return seed % SCENARIOS


def make(num_envs: int) -> ued.GymUPOMDP:
    """Make training environments."""
    kinds = {"radius": ued.LogRange(15, 60), "lanes": ued.Integer(1, 3), "traffic": ued.Range(0.0, 0.3)}
    return ued.GymUPOMDP(road, put, kinds, num_envs, vectorization="async", seed_episodes=scenario)


roads = ued.Task(
    make,
    tests={
        "wide and empty": {"radius": 60, "lanes": 3, "traffic": 0.0},
        "tight and busy": {"radius": 15, "lanes": 2, "traffic": 0.3},
    },
)


def main() -> None:
    import regista

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--env-steps", type=int, default=50_000)
    parser.add_argument("--out", type=Path, default=Path("runs/roads-plr-0"))
    arguments = parser.parse_args()
    settings = {"num_envs": 2, "eval_every": 0, "record": False}
    run = regista.train(roads, method="plr", out=arguments.out, total_env_steps=arguments.env_steps, **settings)
    print(regista.evaluate(run, episodes=2).text())


if __name__ == "__main__":
    main()
