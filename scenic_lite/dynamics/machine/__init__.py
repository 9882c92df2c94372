"""What runs inside the step kernel: the table of instructions, the loop over them, a compiled program."""
