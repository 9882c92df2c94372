"""Benchmark the speed of the simulator, of training and of the language; see `lab.benchmarks.__main__`."""
