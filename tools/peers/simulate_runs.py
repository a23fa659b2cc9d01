#!/usr/bin/env python3
"""Judges random runs of plans: an independent robot, person and judge, written from docs/reference/execution.md. See docs/internals/peers.md.

    tools/peers/simulate_runs.py --runs 2000              a fresh sample; prints its seed
    tools/peers/simulate_runs.py --seed 7 --runs 2000     the same sample again
    tools/peers/simulate_runs.py --only 123456            the runs of one seed of a report, with their logs
    tools/peers/simulate_runs.py --self-test              the judge against wrong runs that it has to reject

Exits with 1 where the judge blames a run.
"""

from simulate.runs.main import main

if __name__ == "__main__":
    main()
