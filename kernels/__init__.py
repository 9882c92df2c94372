"""Compilation for the language and the simulators: the `kernel` decorator, its linking and cache, random numbers.

Imported as `regista.kernels`; `regista/kernels` is a link to this folder. Read next: `jit`.
"""

if __name__ == "kernels":  # imported with the root of a checkout on `sys.path`
    from regista.bare_names import lead_inside

    lead_inside(__name__)
