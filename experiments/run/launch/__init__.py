"""Processes: several runs at a time, who owns a run folder, how signals end a command."""
