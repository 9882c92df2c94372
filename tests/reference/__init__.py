"""What behaviors mean: episodes played by plain Python generators, slowly and obviously."""
