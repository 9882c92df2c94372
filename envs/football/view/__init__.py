"""Matches as pictures, films and records."""
