"""The maze benchmark of PAIRED, DCD, JaxUED and minimax: partially observed mazes, batched and compiled.

An agent turns left, turns right or moves forward in a grid of walls. It sees the 5 x 5 cells ahead of it and the
direction it faces, and is rewarded for reaching the goal early. Dynamics and views are MiniGrid's
(Chevalier-Boisvert et al. 2023). DCD is facebookresearch/dcd, the code of Jiang et al. 2021 and Parker-Holder et al.
2022.

| part | value | source |
|---|---|---|
| cells | 13 x 13 inside a border of walls | DCD `AdversarialEnv(size=15)`, JaxUED `Maze(max_height=13, max_width=13)` |
| walls | at most 25, or a random number below 60 | DCD `GoalLastFewerBlocks`, `GoalLastVariableBlocks`; `levels` |
| view | 5 x 5 cells, walls hide nothing | DCD `AdversarialEnv(see_through_walls=True)`; `view` |
| actions | left, right, forward | MiniGrid's first three; its other four do nothing in a maze without objects |
| steps | 250 | DCD `max_steps=250`, JaxUED `max_steps_in_episode=250` |
| reward | 1 - 0.9 t / T at the goal | MiniGrid `_reward`, the same in JaxUED and minimax |
| time limit | truncation, with bootstrapped value | DCD `handle_timelimits=true`; JaxUED, minimax: one `done` |

Two things differ from the sources. Their agents have seven actions, four of which do nothing. In JaxUED and minimax an
agent that reaches the goal stays in the cell before it. In this package it moves onto the goal, as in MiniGrid. In both
cases the episode is over.

Read next: `grid`, the arrays; `dynamics`, a step; `levels`, mazes as levels; `env`, the environment; `task`, the
training and test mazes of `regista train maze`.
"""
