"""Bodies, ball and their meetings."""
