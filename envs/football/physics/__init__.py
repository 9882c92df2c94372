"""Physics: bodies, ball and collisions."""
