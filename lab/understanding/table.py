#!/usr/bin/env python3
"""Prints one row of totals for each finished run of a suite, as a table in Markdown.

    table.py eval/results/test-care eval/results/sealed-farm-minimum

Totals only, so that it can be used for suites that nobody reads.
"""

import json
import sys
from pathlib import Path

LANGUAGES = ["english", "french", "german", "japanese", "spanish"]


def share(rows, is_counted):
    count = sum(map(is_counted, rows))
    return f"{count} of {len(rows)} ({100 * count / len(rows):.0f} %)" if rows else ""


def is_right(row):
    return row["correct"]


def is_wrong(row):
    return row["outcome"] == "verified" and not row["correct"]


def is_needless(row):
    return "asked_needlessly" in row["failures"]


def row_of(name, rows):
    cells = [name] + [share(rows, one) for one in (is_right, is_wrong, is_needless)]
    for language in LANGUAGES:
        cells.append(share([row for row in rows if language in row["tags"]], is_right))
    verified = [row for row in rows if row["outcome"] == "verified"]
    cells.append(share(verified, is_wrong))
    return "| " + " | ".join(cells) + " |"


def main():
    folders = [Path(argument) for argument in sys.argv[1:]]
    if not folders:
        sys.exit("usage: table.py RUN...")
    titles = ["suite", "right", "verified, and not what was said", "asked needlessly"]
    titles += [language.capitalize() for language in LANGUAGES]
    titles.append("wrong plans of all that were verified")
    print("| " + " | ".join(titles) + " |")
    print("|" + " --- |" * len(titles))
    every = []
    for folder in folders:
        rows = [json.loads(line) for line in (folder / "results.jsonl").read_text().splitlines()]
        print(row_of(folder.name, rows))
        every += rows
    if len(folders) > 1:
        print(row_of("all", every))


if __name__ == "__main__":
    main()
