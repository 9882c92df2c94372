"""The basis of the language: scopes, types, budgets, runtime checks, the domain."""
