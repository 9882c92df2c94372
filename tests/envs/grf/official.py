"""Play the official environment: run by the Python that has gfootball, as `python official.py REQUEST.json RESULT.npz`.

The request names a scenario, a seed, agents of both teams and actions `[T, A]`; the result holds what the official
environment gives after the reset and after every step. Read next: `test_official.py`, which compares.
"""

import json
import sys

import numpy as np

FIELDS = ("ball", "left_team", "left_team_direction", "right_team", "right_team_direction", "sticky_actions", "active")


def main() -> None:
    with open(sys.argv[1]) as file:
        asked = json.load(file)
    import gfootball.env as football
    from gfootball.env.wrappers import Simple115StateWrapper

    env = football.create_environment(
        asked["scenario"],
        representation="raw",
        rewards=asked["rewards"],
        number_of_left_players_agent_controls=asked["agents"][0],
        number_of_right_players_agent_controls=asked["agents"][1],
        other_config_options={"game_engine_random_seed": asked["seed"], "action_set": asked["action_set"]},
    )
    shown = [env.reset()]
    rewards, dones = [], []
    for actions in asked["actions"]:
        observation, reward, done, _ = env.step(actions[0] if len(actions) == 1 else actions)
        shown.append(observation)
        rewards.append(np.atleast_1d(reward))
        dones.append(done)
        if done:
            break
    fields = {  # the frames of both teams have other shapes
        f"{name} {agent}": np.array([step[agent][name] for step in shown])
        for name in FIELDS
        for agent in range(sum(asked["agents"]))
    }
    simple = np.array([Simple115StateWrapper.convert_observation(step, True) for step in shown])
    np.savez(sys.argv[2], simple115=simple, rewards=np.array(rewards), dones=np.array(dones), **fields)


if __name__ == "__main__":
    main()
