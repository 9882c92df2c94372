"""What is done to the whole of Regista for minutes or hours; see `lab.torture.__main__`."""
