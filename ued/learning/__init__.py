"""Students: networks, rollouts, PPO."""
