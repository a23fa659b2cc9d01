"""The command: draws runs, carries them out, prints what came of them."""

import argparse
import collections
import json
import os
import random
import secrets
import subprocess
import sys
import tempfile
import time
import traceback
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from . import program as program_runs
from . import selftest
from .scenario import Source
from .session import Link, Session

ROOT = Path(__file__).resolve().parents[4]
# Seeds that one process takes at a time.
CHUNK = 20
# Disagreements that are printed with their logs.
PRINTED = 12


def build() -> Path:
    """Builds the program that carries out runs, and returns its path."""
    command = ["cargo", "build", "--quiet", "--locked", "-p", "longstep-peers", "--bin", "judge_runs"]
    subprocess.run(command, cwd=ROOT, check=True)
    return Path(os.environ.get("CARGO_TARGET_DIR") or ROOT / "target") / "debug/judge_runs"


def started(program: Path) -> subprocess.Popen:
    """A process of the program."""
    return subprocess.Popen([program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)


def run_seeds(program: Path, seeds: list[int]) -> tuple[collections.Counter, list[dict]]:
    """Carries out the runs of some seeds; returns counts, and what the judge blames."""
    counts: collections.Counter = collections.Counter()
    blamed: list[dict] = []
    process = started(program)
    with tempfile.TemporaryDirectory(dir="/dev/shm" if Path("/dev/shm").is_dir() else None) as folder:
        for seed in seeds:
            for number, scenario in enumerate(Source(seed, Path(folder)).runs()):
                session = Session(scenario, Link(process), folder)
                try:
                    judge = session.run()
                except Exception as error:  # The judge's own mistake: the run is shown, and the others go on.
                    judge = session.judge
                    judge.blame("the judge failed", "".join(traceback.format_exception(error)[-3:]))
                    process.kill()
                    process.wait()
                counts["runs"] += 1
                counts.update(judge.counts)
                counts.update(f"fault {kind}" for kind in session.robot.happened)
                counts["crash"] += session.crashed
                if judge.refusal:
                    counts[f"refusal {judge.refusal[:90]}"] += 1
                for verdict in judge.verdicts:
                    counts["VERDICT " + verdict.split(":")[0]] += 1
                if judge.verdicts:
                    blamed.append(report(seed, number, session))
                if process.poll() is not None:
                    process = started(program)
    process.stdin.close()
    process.wait(timeout=10)
    return counts, blamed


def report(seed: int, number: int, session: Session) -> dict:
    """A run as it is printed: enough to see it, and the seed with which to repeat it."""
    scenario = session.scenario
    return {
        "seed": seed,
        "run": number,
        "verdicts": session.judge.verdicts,
        "goal": scenario.goal,
        "rules": scenario.rules,
        "settings": scenario.settings.as_json(),
        "direct": scenario.direct,
        "plan": [f"{own.name}{own.arguments}" for own in scenario.steps],
        "purpose": [[part.text for part in stage] for stage in scenario.purpose.stages],
        "faults": session.robot.happened,
        "sight": scenario.faults.sight,
        "log": session.log,
    }


def through_program(path: Path, seed: int, count: int) -> int:
    """Runs through the program itself; returns the exit code."""
    begun = time.monotonic()
    counts, blamed = program_runs.campaign(path, seed, count)
    for own in blamed:
        print(f"BLAMED {json.dumps(own)}", flush=True)
    for name, number in sorted(counts.items()):
        print(f"{number:9} {name}")
    print(f"{counts['runs']} runs through the program in {time.monotonic() - begun:.0f} s, seed {seed}")
    return 1 if blamed else 0


def main() -> None:
    """Runs the command."""
    parser = argparse.ArgumentParser(description="Judges random runs of plans with an independent executor.")
    parser.add_argument("--runs", type=int, default=2000, help="how many [default: 2000]")
    parser.add_argument("--seed", type=int, help="what the sample is drawn from [default: a new one, printed]")
    parser.add_argument("--only", type=int, help="the runs of this one seed of a report")
    parser.add_argument("--runner", type=Path, help="the built program `judge_runs` [default: build it]")
    parser.add_argument("--processes", type=int, default=2, help="processes at a time [default: 2]")
    parser.add_argument("--program", type=Path, help="runs through this program `longstep`, with kills")
    parser.add_argument("--full", action="store_true", help="print all counts")
    parser.add_argument("--self-test", action="store_true", help="test the judge itself")
    arguments = parser.parse_args()
    if arguments.self_test:
        sys.exit(1 if selftest.run() else 0)
    seed = arguments.seed if arguments.seed is not None else secrets.randbelow(10**9)
    if arguments.program is not None:
        print(f"seed {seed}", flush=True)
        sys.exit(through_program(arguments.program.resolve(), seed, arguments.runs))
    program = (arguments.runner or build()).resolve()
    if arguments.only is not None:
        counts, blamed = run_seeds(program, [arguments.only])
        for own in blamed:
            print(json.dumps(own, indent=1))
        sys.exit(1 if blamed else 0)
    print(f"seed {seed}", flush=True)
    total, blamed, begun = collections.Counter(), [], time.monotonic()
    draw = random.Random(seed)
    with ProcessPoolExecutor(arguments.processes) as pool:
        while total["runs"] < arguments.runs:
            chunks = [[draw.randrange(10**9) for _ in range(CHUNK)] for _ in range(arguments.processes)]
            for job in [pool.submit(run_seeds, program, chunk) for chunk in chunks]:
                counts, found = job.result()
                total.update(counts)
                for own in found:
                    if len(blamed) < PRINTED:
                        print(f"BLAMED {json.dumps(own)}", flush=True)
                    blamed.append(own)
    spent = time.monotonic() - begun
    for name, count in sorted(total.items()):
        if arguments.full or not name.startswith("refusal"):
            print(f"{count:9} {name}")
    print(f"{total['runs']} runs in {spent:.0f} s ({total['runs'] / spent:.0f} a second), seed {seed}")
    sys.exit(1 if blamed else 0)
