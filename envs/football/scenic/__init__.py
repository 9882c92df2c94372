"""The interface between football matches and Scenic programs."""
