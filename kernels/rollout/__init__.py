"""Whole rollouts in one kernel: a policy's forward pass, action sampling, and the bookkeeping of episodes.

A simulator's own kernel combines them with its step: see `docs/howto/simulator.md`. Read in this order: `lanes`,
vectors of 16 rows; `network`, the layers; `policy`, actions and values; `play`, what a simulator's kernel calls.
"""
