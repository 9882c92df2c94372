"""Repeat the measurements of Google Research Football in our simulator: `python -m lab.benchmarks --suite grf`.

Read in this order: `rows` (what a comparison is), `stage` (how a situation is set up and played), one family, such as
`motion`, then `report`.
"""
