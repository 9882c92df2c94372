"""Running it: the command line, the run folder, comparisons, pictures and benchmarks.

The only package that imports all the others. Imported as `regista.experiments`; `regista/experiments` is a link to this
folder. Read next: `__main__`, then `commands.train`, then `run.build`.
"""

if __name__ == "experiments":  # the root of a checkout is on `sys.path`
    from regista.bare_names import lead_inside

    lead_inside(__name__)
