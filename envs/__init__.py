"""Environments of ours: football, Google Research Football behind the same interface, and a toy world.

Imported as `regista.envs`, in a checkout, too. Read next: `football.vector_env`.
"""
