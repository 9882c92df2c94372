"""Google Research Football (GRF) itself, in separate processes, as a second engine of `football.vector_env`.

Read next: `grf.engine`, how GRF plays a batch of matches; `grf.worker`, the process that runs GRF.
"""
