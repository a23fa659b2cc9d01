#!/usr/bin/env python3
"""Compares the verifier and the search with an independent simulator, on random cases. See docs/internals/peers.md.

    tools/peers/simulate.py --cases 2000              a fresh sample over all classes; prints its seed
    tools/peers/simulate.py --seed 7 --cases 2000     the same sample again
    tools/peers/simulate.py --class tree --cases 500  one class
    tools/peers/simulate.py --tasks 2000              random planning tasks with costs and numbers instead of the classes
    tools/peers/simulate.py --self-test               the simulator against cases worked out by hand, and planted faults

Exits with 1 where the two disagree; each disagreement is printed as small as it gets, with its seed.
"""

from simulate.main import main

if __name__ == "__main__":
    main()
