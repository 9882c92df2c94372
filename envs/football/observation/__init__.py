"""The agents' observations."""
