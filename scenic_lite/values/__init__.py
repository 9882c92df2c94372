"""Random values as expression graphs, and geometry in the plane: vectors, angles, regions."""
