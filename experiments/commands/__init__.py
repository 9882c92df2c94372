"""One module per command of `regista`."""
