"""Behaviors, monitors and conditions compiled into code for the machine (`vm`).

Read next: `dynamics.compiler.compile`.
"""
