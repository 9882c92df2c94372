"""What the language and simulators compile with: the `kernel` decorator, its linking, random numbers."""
