"""Processes: parallel runs, ownership of run folders, and signals."""
