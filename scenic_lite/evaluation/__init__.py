"""The evaluation of the tree: the meaning of each expression and statement, for fixed and random values.

Read next: `loader`, the start of a load; `core.scope`.
"""
