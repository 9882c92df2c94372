"""What agents observe."""
