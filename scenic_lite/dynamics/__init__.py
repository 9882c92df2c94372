"""The dynamic part of the language: behaviors, monitors, conditions that end an episode, modular scenarios.

`core.world` is the interface to a simulator. Read next: `dynamics.compiler.compile`. `tests/reference/interpreter.py`
defines the meaning of every statement.
"""
