"""Damaged folders, wrong calls and signals: attacks that tests try for seconds, and `lab.torture` for hours."""
