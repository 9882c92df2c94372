"""Running it: the command line, the run folder, comparisons, pictures and benchmarks.

The only package that knows the others' names. Read next: `__main__`, then `commands.train`, then `run.build`.
"""
