"""What `regista benchmark` measures."""
