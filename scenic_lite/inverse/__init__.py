"""From a scene back to the level that it is.

Read next: `inverse.levels`.
"""
