"""Random values as expression graphs, and the plane that they lie in: vectors, angles, regions."""
