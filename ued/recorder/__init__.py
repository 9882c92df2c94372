"""The curriculum as a Rerun recording."""
