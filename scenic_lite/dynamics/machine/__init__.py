"""The virtual machine: the table of opcodes, the loop that executes code, and compiled programs."""
