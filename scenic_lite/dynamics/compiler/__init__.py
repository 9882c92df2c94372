"""The compiler of behaviors, monitors and conditions into code for the virtual machine (`vm`).

Read next: `dynamics.compiler.compile`.
"""
