"""From agents' actions to players, and from matches to rewards."""
