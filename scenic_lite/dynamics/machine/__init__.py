"""The virtual machine: the table of instructions, the loop over them, a compiled program."""
