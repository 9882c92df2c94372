"""The plane: vectors and angles, regions, vector fields.

Read next: `values.geometry`, `values.regions`.
"""
