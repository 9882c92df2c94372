"""The basis of the language: scopes, types, budgets, runtime checks, and the domain."""
