"""The evaluation of the tree: what each expression and statement means, for numbers and random values alike.

Read next: `loader`, where a load begins; `core.scope`.
"""
