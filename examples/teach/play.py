"""Plays a recording at the speed at which it was made: a recorder without a hand tracker.

    longstep teach plan.json --recorder "python3 examples/teach/play.py demo.csv"

Writes the frames of a CSV file one by one, as a program that tracks a hand does. If the file has a column `step`, only the
frames of the step that is to be shown (LONGSTEP_STEP) are played. Then it waits for Ctrl-C.
"""

import argparse
import csv
import json
import os
import sys
import threading
import time

TEXTS = ("hand", "grasp", "frame")


def chosen(rows):
    """The frames of the step that Longstep asks for; all frames if none of them names a step."""
    step = os.environ.get("LONGSTEP_STEP")
    if step is None or not rows or not rows[0].get("step"):
        return rows
    return [row for row in rows if row["step"] == step]


def as_json(row):
    """A frame as an object: empty columns are left out."""
    return json.dumps({name: value if name in TEXTS else float(value) for name, value in row.items()
                       if value != "" and name != "step"})


def play(rows, options):
    begun, first = time.monotonic(), float(rows[0]["t"]) if rows else 0
    writer = csv.DictWriter(sys.stdout, fieldnames=list(rows[0]) if rows else [], lineterminator="\n")
    if not options.json:
        writer.writeheader()
    for row in rows:
        due = begun + (float(row["t"]) - first) / options.speed
        time.sleep(max(0, due - time.monotonic()))
        if options.json:
            print(as_json(row))
        else:
            writer.writerow(row)
        # Each frame at once: Longstep says when it has the first one.
        sys.stdout.flush()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("recording", help="a CSV file")
    parser.add_argument("--speed", type=float, default=1, metavar="FACTOR", help="play faster or slower")
    parser.add_argument("--json", action="store_true", help="write JSON Lines in place of CSV")
    parser.add_argument("--once", action="store_true", help="end after the last frame")
    options = parser.parse_args()
    with open(options.recording, encoding="utf-8", newline="") as file:
        rows = chosen(list(csv.DictReader(file)))
    try:
        play(rows, options)
        if not options.once:
            threading.Event().wait()
    except KeyboardInterrupt:
        pass


if __name__ == "__main__":
    main()
