"""The evaluation of the tree: the meaning of each expression and statement, for numbers and random values alike.

Read next: `loader`, where a load begins; `core.scope`.
"""
