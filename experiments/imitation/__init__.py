"""Demonstrations and behavior cloning: what `regista demonstrate` saves and `regista clone` learns from."""
