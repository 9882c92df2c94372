"""The experiments of the thesis's chapter 4; see `lab.thesis.__main__`."""
