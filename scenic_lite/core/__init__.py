"""What every chapter of the language stands on: scopes, types, budgets, runtime checks, the domain."""
