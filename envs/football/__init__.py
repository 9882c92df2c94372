"""A football simulator that behaves like Google Research Football, batched and compiled.

Read next: `simulator`, one step of a match; `state`, the record of a match; `vector_env`, the environment.
"""
