#!/usr/bin/env python3
"""Reads recordings of runs with the Python package `mcap`, and compares each with the log that it was made of.

    $(scripts/mcap.sh) tools/peers/recorded_run.py [--list] RUN.jsonl RUN.mcap [RUN.jsonl RUN.mcap ...]

Every step of the log is in the recording with its end and its time, and nothing else; so are observations, plans and
the end of the run. `--list` prints the steps. Exits with 1 where the two differ.
"""

import json
import sys
from datetime import datetime, timezone

from mcap.reader import make_reader

STEP_EVENTS = {"announced", "ordered", "performed", "failed", "found", "judged"}
RUN_EVENTS = {"began", "approved", "refused", "paused", "continued", "interrupted", "confirmed", "trusted", "stopped",
              "done"}
# The channel, for each kind of event that a recording has a message for.
TOPICS = {"observed": "/longstep/observation", "assessed": "/longstep/assessment", "changed": "/longstep/plan"}


def nanoseconds(text):
    """Returns a time of a log as nanoseconds since 1970; `datetime` has microseconds only."""
    whole, _, fraction = text.removesuffix("Z").partition(".")
    second = datetime.fromisoformat(whole).replace(tzinfo=timezone.utc)
    return int(second.timestamp()) * 1_000_000_000 + int((fraction or "0").ljust(9, "0"))


def state_of(event):
    if event["event"] != "judged":
        return event["event"]
    return "judged-done" if event["done"] else "judged-not-done"


def expected(path):
    """Returns the messages that a log should have become, as (topic, time, fields)."""
    with open(path, encoding="utf-8", newline="\n") as file:
        lines = [json.loads(line) for line in file.read().split("\n") if line]
    calls, messages, plans = {}, [], 0
    for event in lines[1:]:
        kind, at = event["event"], nanoseconds(event["at"])
        if kind in STEP_EVENTS:
            if kind == "ordered":
                calls[event["order"]] = event["call"]
            call = event.get("call", calls.get(event["order"]))
            messages.append(("/longstep/step", at, {
                "order": event["order"], "state": state_of(event), "call": call, "outcome": event.get("outcome"),
                "why": event.get("why"), "step": event.get("step")}))
        if kind == "began":
            messages.append(("/longstep/plan", at, {"number": 0, "task_tree": event["plan"]}))
        if kind == "changed":
            plans += 1
            messages.append(("/longstep/plan", at, {"number": plans, "task_tree": event["plan"], "steps": event["steps"]}))
        if kind == "observed":
            messages.append((TOPICS[kind], at, {"statements": event["statements"]}))
        if kind == "assessed":
            messages.append((TOPICS[kind], at, {"effect": event["effect"], "because": event["because"]}))
        if kind in RUN_EVENTS:
            messages.append(("/longstep/run", at, {"event": kind}))
        if kind in ("began", "stopped", "done"):
            messages.append(("/longstep/world", at, {"environment": event["environment"]}))
    return lines[0], messages


def recorded(path):
    """Returns the metadata and the messages of a recording, but the lines for people."""
    with open(path, "rb") as file:
        reader = make_reader(file, validate_crcs=True)
        metadata = {record.name: record.metadata for record in reader.iter_metadata()}
        messages, sequences = [], {}
        for schema, channel, message in reader.iter_messages(log_time_order=False):
            if (schema.encoding, channel.message_encoding) != ("jsonschema", "json"):
                raise ValueError(f"{channel.topic} is {schema.encoding}, {channel.message_encoding}")
            json.loads(schema.data)
            if sequences.get(channel.topic, -1) + 1 != message.sequence:
                raise ValueError(f"{channel.topic}: message {message.sequence} is out of order")
            sequences[channel.topic] = message.sequence
            fields = json.loads(message.data)
            if channel.topic != "/longstep/log":
                messages.append((channel.topic, message.log_time, fields))
    return metadata["longstep"], messages


def step_line(at, fields):
    words = fields.get("outcome") or fields.get("why") or ""
    return f"{at}  {fields['order']:>4}  {fields['state']:<15}  {fields.get('call', '')}  {words}".rstrip()


def differences(log, recording):
    header, wanted = expected(log)
    metadata, found = recorded(recording)
    for name in ("robot", "domain"):
        if metadata[name] != header[name]:
            yield f"metadata: {name} is {metadata[name]!r}, not {header[name]!r}"
    # Within an event the order of topics is free.
    key = lambda message: (message[1], message[0])
    wanted, found = sorted(wanted, key=key), sorted(found, key=key)
    if len(wanted) != len(found):
        yield f"{len(found)} messages, not {len(wanted)}"
    for (topic, at, fields), (other_topic, other_at, message) in zip(wanted, found):
        if (topic, at) != (other_topic, other_at):
            yield f"{other_topic} at {other_at}, not {topic} at {at}"
        for name, value in fields.items():
            # The number of a step is in its order, and repeated afterwards.
            if name == "step" and value is None:
                continue
            if message.get(name) != value:
                yield f"{topic} at {at}: {name} is {message.get(name)!r}, not {value!r}"


def main(arguments):
    is_listing = "--list" in arguments
    files = [own for own in arguments if own != "--list"]
    if not files or len(files) % 2:
        sys.exit(__doc__)
    pairs = list(zip(files[::2], files[1::2]))
    steps = wrong = 0
    for log, recording in pairs:
        for difference in differences(log, recording):
            wrong += 1
            print(f"{recording}: {difference}")
        for topic, at, fields in recorded(recording)[1]:
            if topic == "/longstep/step":
                steps += 1
                if is_listing:
                    print(step_line(at, fields))
    print(f"{len(pairs)} recordings with {steps} messages about steps, {wrong} differences")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main(sys.argv[1:])
