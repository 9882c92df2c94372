"""Scores and networks of a user, for the tests that name them."""

import numpy as np
import torch
from torch import nn

from ued.levels.record import mean_played
from ued.levels.scores import learnability

calls = []


def spread(records, best):
    """Return the standard deviation of returns on each level."""
    calls.append(len(records))
    return np.nanstd(records["returns"][:, 0], 1)


def lowest(records, best):
    return best - mean_played(records["returns"][:, 0])


def vandal(records, best):
    records["returns"] = best[:] = 7.0
    return np.arange(len(best))


def short(records, best):
    return np.zeros(3)


def missing(records, best):
    return np.full(len(best), np.nan)


def masked(records, best):
    return np.ma.array(best.astype(int), mask=np.arange(len(best)) == 1)


def failing(records, best):
    return records["no_such_field"]


def alone(records):
    return np.zeros(len(records))


def novel(records, best):
    return records["novelty"][:, 0].mean(1) + records["level"]["theta"].mean(1)


def learnable(records, best):
    return learnability(records, best)


class Net(nn.Module):
    """Two layers of torch's own initialization, with a skip connection."""

    def __init__(self, space, config):
        super().__init__()
        self.first = nn.Linear(int(np.prod(space.shape)), config.hidden_size)
        self.second = nn.LazyLinear(config.hidden_size)

    def forward(self, observation):
        first = torch.relu(self.first(observation.flatten(1)))
        return first + torch.relu(self.second(first))


class Noisy(Net):
    def __init__(self, space, config):
        super().__init__(space, config)
        self.drop = nn.Dropout(0.1)


class Flat(Net):
    def forward(self, observation):
        return super().forward(observation).sum(1)


class Broken(Net):
    def __init__(self, space, config):
        super().__init__(space, config)
        self.first = nn.Linear(1, 7)


def no_network(space, config):
    return "a network"
