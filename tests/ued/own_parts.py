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


def leaving_score(records, best):
    raise SystemExit(3)


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
    rate = 0.1

    def __init__(self, space, config):
        super().__init__(space, config)
        self.drop = nn.Dropout(self.rate)

    def forward(self, observation):
        return self.drop(super().forward(observation))


class Quiet(Noisy):
    rate = 0.0


class Frozen(Net):
    def __init__(self, space, config):
        super().__init__(space, config)
        self.first.requires_grad_(False)


class FunctionalNoise(Net):
    def forward(self, observation):
        return nn.functional.dropout(super().forward(observation), 0.5)


class RecurrentNoise(nn.Module):
    def __init__(self, space, config):
        super().__init__()
        self.layers = nn.GRU(int(np.prod(space.shape)), 8, 2, dropout=0.5, batch_first=True)

    def forward(self, observation):
        return self.layers(observation.flatten(1)[:, None])[0][:, 0]


class Spectral(Net):
    def __init__(self, space, config):
        super().__init__(space, config)
        self.first = nn.utils.parametrizations.spectral_norm(self.first)


class Normed(Net):
    def __init__(self, space, config):
        super().__init__(space, config)
        self.norm = nn.BatchNorm1d(config.hidden_size)

    def forward(self, observation):
        return self.norm(super().forward(observation))


class Waves(Net):
    """Random Fourier features (Rahimi and Recht 2007), whose rounding errors are large."""

    def __init__(self, space, config):
        super().__init__(space, config)
        self.register_buffer("frequencies", 300 * torch.randn(50 * int(np.prod(space.shape)), 8))

    def forward(self, observation):
        waves = torch.sin(observation.flatten(1).repeat(1, 50) @ self.frequencies)
        return torch.cat([super().forward(observation), waves], 1)


class UnsavedWaves(Waves):
    def __init__(self, space, config):
        super().__init__(space, config)
        frequencies = self.frequencies
        del self.frequencies
        self.frequencies = frequencies


class Counting(Net):
    calls = 0

    def forward(self, observation):
        self.calls += 1
        return super().forward(observation) + self.calls


class Centered(Net):
    def forward(self, observation):
        features = super().forward(observation)
        return features - features.mean(0)


class Squeezed(Net):
    def forward(self, observation):
        return super().forward(observation).squeeze()


class Cut(Net):
    def forward(self, observation):
        with torch.no_grad():
            return super().forward(observation)


class Unused(Net):
    """Has a layer that forward does not call, and keeps its features."""

    def __init__(self, space, config):
        super().__init__(space, config)
        self.spare = nn.Linear(2, 2)

    def forward(self, observation):
        self.last = super().forward(observation)
        return self.last


class Unlisted(nn.Module):
    def __init__(self, space, config):
        super().__init__()
        self.weights = [nn.Parameter(torch.ones(int(np.prod(space.shape)), 4))]

    def forward(self, observation):
        return observation.flatten(1) @ self.weights[0]


class Wide(Net):
    def forward(self, observation):
        return super().forward(observation).double()


class WideWeights(nn.Module):
    def __init__(self, space, config):
        super().__init__()
        self.layer = nn.Linear(int(np.prod(space.shape)), 4).double()

    def forward(self, observation):
        return self.layer(observation.flatten(1).double()).float()


class InPlace(Net):
    def forward(self, observation):
        return super().forward(observation.mul_(0.5))


class Undefined(Net):
    def forward(self, observation):
        return super().forward(observation) * float("nan")


def leaving(space, config):
    raise SystemExit(3)


class Flat(Net):
    def forward(self, observation):
        return super().forward(observation).sum(1)


class Broken(Net):
    def __init__(self, space, config):
        super().__init__(space, config)
        self.first = nn.Linear(1, 7)


def no_network(space, config):
    return "a network"
