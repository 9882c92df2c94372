"""Policies in our simulator and in Google Research Football, on the same levels; see `transfer.replaying`."""
