"""Attacks on all of Regista for minutes or hours; see `lab.torture.__main__`."""
