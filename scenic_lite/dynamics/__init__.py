"""The dynamic half of the language: behaviors, monitors, conditions that end an episode, modular scenarios.

`world` is the seam to a simulator. Read next: `dynamics.compiler.compile`. `tests/reference/interpreter.py`
defines what every statement means.
"""
