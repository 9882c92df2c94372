"""Football as Scenic programs see it."""
