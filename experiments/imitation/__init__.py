"""Demonstrations and behavior cloning: the data of `regista demonstrate`, from which `regista clone` learns."""
