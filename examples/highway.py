"""A driving task: highway-env's highway; the parameters are the number of lanes and cars, and their density.

    regista train examples/highway.py:highway --method paired
    regista inspect examples/highway.py:highway --png highway.png

It requires `pip install highway-env`. `put` returns the `options` for `reset`, which is how highway-env sets its
configuration. `roads.py` does the same with MetaDrive.
"""

import argparse
from pathlib import Path
from typing import Any

import gymnasium

import ued


def put(env: gymnasium.Env, values: dict[str, Any]) -> dict[str, Any]:
    """Return the options of `reset` that apply one level to an environment."""
    cars = {"lanes_count": values["lanes"], "vehicles_count": values["cars"], "vehicles_density": values["density"]}
    return {"config": {**cars, "duration": 20, "offscreen_rendering": True}}


def road() -> gymnasium.Env:
    """Make one highway."""
    import highway_env  # noqa: F401  # registers its ids

    return gymnasium.make("highway-fast-v0", render_mode="rgb_array")


def make(num_envs: int) -> ued.GymUPOMDP:
    """Make training environments; a valid level has at most 8 cars per lane."""
    kinds = {"lanes": ued.Integer(1, 4), "cars": ued.Integer(2, 20), "density": ued.LogRange(0.5, 2.0)}
    return ued.GymUPOMDP(road, put, kinds, num_envs, valid=lambda level: level["cars"] <= 8 * level["lanes"])


highway = ued.Task(
    make,
    tests={
        "open road": {"lanes": 3, "cars": 5, "density": 0.5},
        "rush hour": {"lanes": 3, "cars": 20, "density": 2.0},
    },
)


def main() -> None:
    import regista

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--env-steps", type=int, default=20_000)
    parser.add_argument("--out", type=Path, default=Path("runs/highway-paired-0"))
    arguments = parser.parse_args()
    settings = {"num_envs": 4, "eval_every": 0, "record": False}
    run = regista.train(highway, method="paired", out=arguments.out, total_env_steps=arguments.env_steps, **settings)
    print(regista.evaluate(run, episodes=4, levels=0).text())


if __name__ == "__main__":
    main()
