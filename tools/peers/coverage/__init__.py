"""Random solvable tasks of eight domains, for the comparison of searches (docs/internals/peers.md)."""
