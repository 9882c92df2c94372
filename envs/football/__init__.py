"""A football simulator that behaves like Google Research Football, batched and compiled.

Read next: `state` for the record of a match, `simulator` for a step of it, `scenic.step` for a step with its program.
"""
