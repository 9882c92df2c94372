"""Matches as pictures, videos and records."""
