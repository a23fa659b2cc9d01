#!/usr/bin/env python3
"""Searches for small inputs that cost too much: more than 2 s of processor time or 300 MB in a command without a model.

  tools/hostile/search.py --program target/release/longstep --minutes 120 --jobs 2 --seed 1 --out found

Every input over a limit is printed, made smaller and kept in a folder of its own with the command that shows it. The last
table lists, for each family of inputs, how many were run and the most that one took. Exits with 1 if anything was found.
docs/internals/hostile-inputs.md tells how the search works.
"""

import argparse
import json
import math
import os
import random
import shlex
import shutil
import signal
import sys
import threading
import time
from dataclasses import dataclass
from types import SimpleNamespace

import authoring
import domains
import examples
import plans
import rules
import runs
import sessions
from climb import FINDINGS, Climber, minimised
from measure import Case, Cost, Runner, write_files

FAMILIES = [family for part in (plans, sessions, domains, rules, runs, authoring, examples) for family in part.FAMILIES]
EMPTY = Case({"plan.json": '{"task_cohesion": {"task_sequence": []}}', "env.json": '{"assets": ["<a>"], "objects": []}'}, ("verify", "plan.json", "--env", "env.json"))
# The runs that making a finding smaller may take.
TRIES = 60


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0], epilog=__doc__.split("\n\n", 1)[1], formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", required=True, help="the built program; a release build for figures that are quoted")
    parser.add_argument("--minutes", type=float, default=10)
    parser.add_argument("--jobs", type=int, default=1, help="processes at a time")
    parser.add_argument("--seed", type=int, default=None, help="[default: drawn, and printed]")
    parser.add_argument("--out", default="hostile-found", help="folder for what is found; what a former search left is kept")
    parser.add_argument("--family", action="append", help="only families whose name has this in it")
    parser.add_argument("--seconds", type=float, default=2.0, help="limit of processor time, user and system")
    parser.add_argument("--megabytes", type=float, default=300.0, help="limit of resident memory")
    parser.add_argument("--cpu-limit", type=int, default=20, help="seconds after which a run is ended")
    parser.add_argument("--address-limit", type=int, default=2048, help="MiB of address space that a run may have")
    return parser.parse_args()


@dataclass
class Finding:
    """An input over a limit."""

    why: str
    genome: object
    cost: Cost
    folder: str


class Search:
    """The families, what they have found, and whose turn it is."""

    def __init__(self, options, seed):
        self.options = options
        self.rng = random.Random(seed)
        self.limits = SimpleNamespace(seconds=options.seconds, mebibytes=options.megabytes * 1e6 / (1 << 20))
        wanted = [family for family in FAMILIES if not options.family or any(word in family.name for word in options.family)]
        self.climbers = [Climber(family, self.limits, self.rng) for family in wanted]
        self.runner = Runner(options.program, options.cpu_limit, options.address_limit, wall_seconds=20 * options.cpu_limit)
        self.lock = threading.Lock()
        # As long as is needed to see that a run is over the limit; what is kept is measured for longer.
        self.enough = min(options.cpu_limit, math.ceil(options.seconds) + 2)
        self.until = time.monotonic() + 54 * options.minutes
        self.crashes = {}
        self.failure = None

    def why(self, cost):
        """Which limit a run went over; none if it kept to them."""
        if cost.seconds > self.limits.seconds or cost.end in ("SIGXCPU", "SIGKILL"):
            return "time"
        # Memory that could not be had is a limit that was gone over as well.
        if cost.mebibytes > self.limits.mebibytes or "memory allocation" in cost.stderr:
            return "memory"
        return None

    def confirmed(self, climber, genome, why, times):
        """The least that further runs of the genome take; none if one keeps to the limits, as when a machine is busy."""
        case, least = climber.family.build(genome), None
        for _ in range(times):
            cost = self.runner.run(case, self.enough)
            climber.spent += cost.seconds
            if self.why(cost) != why:
                return None
            least = cost if least is None or cost.seconds < least.seconds else least
        return least

    def work(self):
        try:
            while time.monotonic() < self.until and self.failure is None:
                self.step()
        except Exception as error:
            self.failure = error
            raise

    def turn(self):
        """The family that comes next: mostly the one that has had the least processor time."""
        if self.rng.random() < 0.3:
            return self.rng.choice(self.climbers)
        return min(self.climbers, key=lambda climber: (climber.spent / climber.weight(), climber.runs))

    def step(self):
        with self.lock:
            climber = self.turn()
            genome = climber.next()
        if genome is None:
            return
        family = climber.family
        cost = self.runner.run(family.build(genome), self.enough)
        with self.lock:
            climber.take(genome, cost)
            open_places = len(climber.over) < FINDINGS
        crashed = "panicked at" in cost.stderr or cost.end in ("SIGABRT", "SIGSEGV", "SIGILL", "SIGBUS")
        if crashed and "memory allocation" not in cost.stderr:
            self.keep_crash(family, genome, cost)
        why = self.why(cost)
        if why and open_places:
            self.keep(climber, genome, why)

    def keep(self, climber, genome, why):
        """Keeps a genome that is over a limit, if it is so each time; it is made smaller when the search is over."""
        cost = self.confirmed(climber, genome, why, 2)
        if cost is None:
            return
        case = climber.family.build(genome)
        with self.lock:
            number = len(climber.over) + 1
            folder = self.save(f"{climber.family.name}-{number}".replace(": ", "-").replace(" ", "-"), case, cost, genome)
            climber.over.append(Finding(why, genome, cost, folder))
        print(f"OVER THE LIMIT ({why}): {climber.family.name}: {cost.seconds:.2f} s, {cost.mebibytes:.0f} MiB, ended with {cost.end}: {folder}", flush=True)

    def make_smaller(self):
        """Makes the first finding of each family smaller and replaces its folder, for a tenth of the time."""
        until = time.monotonic() + 6 * self.options.minutes
        found = [climber for climber in self.climbers if climber.over]
        for number, climber in enumerate(found):
            share = time.monotonic() + (until - time.monotonic()) / (len(found) - number)
            first = climber.over[0]

            def is_still_over(genome):
                cost = self.confirmed(climber, genome, first.why, 1) if time.monotonic() < share else None
                if cost is not None:
                    first.genome, first.cost = genome, cost
                return cost is not None

            minimised(climber.family, first.genome, is_still_over, TRIES)
            case = climber.family.build(first.genome)
            longer = self.runner.run(case)
            if self.why(longer) == first.why:
                first.cost = longer
            self.save(os.path.basename(first.folder), case, first.cost, first.genome)
            print(f"smallest of {climber.family.name}: {first.cost.seconds:.2f} s, {first.cost.mebibytes:.0f} MiB: {first.folder}", flush=True)

    def keep_crash(self, family, genome, cost):
        lines = [line for line in cost.stderr.splitlines() if "panicked at" in line] or [cost.end]
        with self.lock:
            place = lines[0].split("panicked at")[-1].strip()
            if place in self.crashes:
                return
            case = family.build(genome)
            self.crashes[place] = self.save(f"crash-{len(self.crashes) + 1}", case, cost, genome)
        print(f"CRASH: {family.name}: {lines[0]}: {self.crashes[place]}", flush=True)

    def save(self, name, case, cost, genome):
        folder = os.path.join(self.options.out, name)
        shutil.rmtree(folder, ignore_errors=True)
        os.makedirs(folder)
        write_files(case.files, folder)
        with open(os.path.join(folder, "command.sh"), "w", encoding="utf-8", errors="surrogateescape") as file:
            file.write(f'cd "$(dirname "$0")" && exec "${{1:-longstep}}" {shlex.join(case.argv)}\n')
        told = {"seconds": round(cost.seconds, 3), "mebibytes": round(cost.mebibytes, 1), "end": cost.end, "stderr": cost.stderr}
        if isinstance(genome, dict):
            told["genes"] = genome
        with open(os.path.join(folder, "cost.json"), "w", encoding="utf-8") as file:
            json.dump(told, file, indent=1)
        return folder

    def report(self, baseline):
        print(f"\nan empty run takes {baseline.seconds:.3f} s of processor time and {baseline.mebibytes:.0f} MiB, which are part of every figure")
        print(f"{'family':<28}{'runs':>8}{'most time':>12}{'most memory':>14}{'over':>6}{'restarts':>10}")
        for climber in self.climbers:
            name, runs = climber.family.name, climber.runs
            print(f"{name:<28}{runs:>8}{climber.worst_seconds:>10.2f} s{climber.worst_mebibytes:>10.0f} MiB{len(climber.over):>6}{climber.restarts:>10}")
        total, over = sum(climber.runs for climber in self.climbers), sum(len(climber.over) for climber in self.climbers)
        print(f"{total} runs, {over} inputs over a limit, {len(self.crashes)} crashes; kept in {self.options.out}")
        return over + len(self.crashes)


def interrupt(*_):
    raise KeyboardInterrupt


def main():
    options = arguments()
    # A shell that starts it in the background has it ignore Ctrl-C, so the interrupt is raised here.
    signal.signal(signal.SIGTERM, interrupt)
    seed = options.seed if options.seed is not None else random.SystemRandom().randrange(1 << 32)
    print(f"seed {seed}; limits {options.seconds} s and {options.megabytes} MB; every file and argument has at most 20000 bytes", flush=True)
    search = Search(options, seed)
    try:
        baseline = min((search.runner.run(EMPTY) for _ in range(5)), key=lambda cost: cost.seconds)
        if baseline.end not in ("0", "10"):
            sys.exit(f"the program does not run: {baseline.end}: {baseline.stderr}")
        workers = [threading.Thread(target=search.work, daemon=True) for _ in range(options.jobs)]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        if search.failure is None:
            search.make_smaller()
    except KeyboardInterrupt:
        search.until = 0
    finally:
        found = search.report(baseline)
        search.runner.close()
    sys.exit(2 if search.failure else 1 if found else 0)


if __name__ == "__main__":
    main()
