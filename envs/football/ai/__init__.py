"""The built-in players."""
