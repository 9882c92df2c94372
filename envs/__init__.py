"""Regista's environments: football, Google Research Football behind the same interface, mazes, and a toy world.

Imported as `regista.envs`; `regista/envs` is a link to this folder. Read next: `football.vector_env`.
"""

if __name__ == "envs":  # the root of a checkout is on `sys.path`
    from regista.bare_names import lead_inside

    lead_inside(__name__)
