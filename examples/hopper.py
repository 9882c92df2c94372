"""MuJoCo's hopper on other planets, with any method; the parameters are gravity and the mass of the torso.

    regista train examples/hopper.py:hopper --method plr
    regista compare examples/hopper.py:hopper --methods dr plr accel --seeds 3

It requires `pip install 'gymnasium[mujoco]'`. Run as a script, this file trains PLR and evaluates the policy.
"""

import argparse
from pathlib import Path

import gymnasium

import ued


def put(env: gymnasium.Env, values: dict[str, float]) -> None:
    """Apply one level to an environment."""
    model = env.unwrapped.model
    model.opt.gravity[2] = -values["gravity"]
    torso = model.body("torso").id
    if not hasattr(env.unwrapped, "usual_mass"):
        env.unwrapped.usual_mass = model.body_mass[torso].copy()
    model.body_mass[torso] = env.unwrapped.usual_mass * values["mass"]


def make(num_envs: int) -> ued.GymUPOMDP:
    """Make training environments."""
    ranges = {"gravity": ued.Range(3.0, 15.0), "mass": ued.LogRange(0.5, 2.0)}
    return ued.GymUPOMDP(lambda: gymnasium.make("Hopper-v5", render_mode="rgb_array"), put, ranges, num_envs)


hopper = ued.Task(
    make,
    tests={
        "earth": {"gravity": 9.81, "mass": 1.0},
        "mars, loaded": {"gravity": 3.71, "mass": 2.0},
        "heavy": [{"gravity": 15.0, "mass": 1.0}, {"gravity": 15.0, "mass": 2.0}],
    },
)


def main() -> None:
    import regista

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--env-steps", type=int, default=200_000)
    parser.add_argument("--out", type=Path, default=Path("runs/hopper-plr-0"))
    arguments = parser.parse_args()
    run = regista.train(hopper, method="plr", out=arguments.out, total_env_steps=arguments.env_steps, record=False)
    print(regista.evaluate(run, episodes=8, levels=0).text())


if __name__ == "__main__":
    main()
