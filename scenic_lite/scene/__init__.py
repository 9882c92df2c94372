"""From θ to scenes: the program, its constraints, pruning and the names of its columns."""
