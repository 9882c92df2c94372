"""The plane: vectors and angles, regions, vector fields.

Read next: `geometry`, `regions`.
"""
