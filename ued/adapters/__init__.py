"""Adapters to other libraries: Gymnasium, Stable-Baselines3, TorchRL; mixtures of programs; trained policies."""
