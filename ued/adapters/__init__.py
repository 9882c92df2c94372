"""Other libraries on either side of the seam: Gymnasium, Stable-Baselines3, TorchRL; mixtures; trained policies."""
