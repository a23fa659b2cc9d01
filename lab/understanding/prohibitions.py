#!/usr/bin/env python3
"""Counts what became of the prohibitions in finished runs of the suites in prohibitions/.

    prohibitions.py eval/results/prohibitions-*

A prohibition is kept if the constraints of the understood goal are those of one of the expected goals, and lost if the goal has
none and is acted on. What has other constraints is listed, for a person to look at. `--list` prints all but those that were kept.
"""

import argparse
import json
import re
from collections import Counter
from pathlib import Path

CONSTRAINT = re.compile(r"(never|always|untouched)\b")


def constraints(parts: list[str]) -> frozenset[str]:
    return frozenset(part.strip() for part in parts if CONSTRAINT.match(part.strip()))


def outcome(row: dict) -> str:
    """What became of the prohibition: kept, question, no plan, lost, or other."""
    if row["outcome"] != "verified":
        return "question" if row["outcome"] == "question" else "no plan"
    understood = constraints(row["understood"])
    if understood in {constraints(goal.split(" & ")) for goal in row["expected"]["plan"]}:
        return "kept"
    return "other" if understood else "lost"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", nargs="+", type=Path)
    parser.add_argument("--list", action="store_true", help="print every row whose prohibition was not kept")
    options = parser.parse_args()
    total: Counter[str] = Counter()
    for run in options.run:
        rows = [json.loads(line) for line in (run / "results.jsonl").read_text(encoding="utf-8").splitlines()]
        counts = Counter(outcome(row) for row in rows)
        total += counts
        print(f"{run.name}: {len(rows)} rows, {dict(sorted(counts.items()))}")
        if options.list:
            for row in rows:
                if outcome(row) != "kept":
                    print("  ", outcome(row), "|", row["says"], "|", " & ".join(row["understood"]), "|", row["question"])
    print(f"all: {sum(total.values())} rows, {dict(sorted(total.items()))}")


if __name__ == "__main__":
    main()
