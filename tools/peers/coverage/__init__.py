"""Random solvable tasks of eight domains, for the comparison of searches (docs/peers.md)."""
