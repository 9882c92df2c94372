"""Google Research Football itself, in processes of its own, as a second engine under `football.vector_env`.

Read next: `grf.engine`, how a batch of matches is played there; `grf.worker`, the process that holds the engine.
"""
