"""The dynamic half of the language: behaviors, monitors, conditions that end an episode, modular scenarios.

`world` is the seam to a simulator. Read next: `dynamics.reference.interpreter`, which defines what every statement
means.
"""
