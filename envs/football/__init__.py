"""A football simulator that behaves like Google Research Football, batched and compiled.

Read next: `simulator`, what a step of a match is; `state`, the record of a match; `vector_env`, matches for learners.
"""
