"""What is done to the whole of Regista for minutes or hours; see `tests.torture.__main__`."""
