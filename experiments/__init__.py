"""The application: the command line, run folders, comparisons, pictures and benchmarks.

This package may import all others. Import it as `regista.experiments`; `regista/experiments` is a link to this
folder. Read next: `__main__`, then `commands.train`, then `run.build`.
"""

if __name__ == "experiments":  # the root of a checkout is on `sys.path`
    from regista.bare_names import lead_inside

    lead_inside(__name__)
