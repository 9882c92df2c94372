"""From program text to a checked syntax tree.

Read next: `syntax.parser`.
"""
