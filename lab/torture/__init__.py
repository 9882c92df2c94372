"""Attacks on the whole of Regista for minutes or hours; see `lab.torture.__main__`."""
