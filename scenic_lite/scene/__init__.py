"""From θ to scenes: the program, its constraints, pruning, and the names of the columns of θ."""
