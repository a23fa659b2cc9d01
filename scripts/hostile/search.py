#!/usr/bin/env python3
"""Searches for small inputs that cost too much: more than 2 s of processor time or 300 MB in a command without a model.

  scripts/hostile/search.py --program target/release/longstep --minutes 120 --jobs 2 --seed 1 --out found

Every input over a limit is printed, made smaller and kept in a folder of its own with the command that shows it. The last
table lists, for each family of inputs, how many were run and the most that one took. Exits with 1 if anything was found.
docs/hostile-inputs.md tells how the search works.
"""

import argparse
import json
import math
import os
import random
import shlex
import shutil
import sys
import threading
import time
from types import SimpleNamespace

import domains
import examples
import plans
import sessions
from climb import FINDINGS, Climber, minimised
from measure import Case, Runner, write_files

FAMILIES = plans.FAMILIES + sessions.FAMILIES + domains.FAMILIES + examples.FAMILIES
EMPTY = Case({"plan.json": '{"task_cohesion": {"task_sequence": []}}', "env.json": '{"assets": ["<a>"], "objects": []}'}, ("verify", "plan.json", "--env", "env.json"))
# The runs that making the first finding of a family smaller may take; further ones may take fewer.
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
        self.until = time.monotonic() + 60 * options.minutes
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

    def confirmed(self, case, why, times=2):
        """The least that further runs of the case take, while they are over the limit: a busy machine counts once."""
        least = None
        for _ in range(times):
            cost = self.runner.run(case, self.enough)
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

    def step(self):
        with self.lock:
            climber = self.rng.choices(self.climbers, [climber.weight() for climber in self.climbers])[0]
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
        family = climber.family
        if self.confirmed(family.build(genome), why) is None:
            return
        with self.lock:
            tries = TRIES // (1 + len(climber.over)) ** 2
        smallest = minimised(family, genome, lambda other: self.is_still_over(family, other, why), tries)
        case = family.build(smallest)
        cost = self.runner.run(case)
        with self.lock:
            command = " ".join(case.argv[:2])
            if any(known[:2] == (why, command) and known[2] == case for known in climber.over):
                return
            number = len(climber.over) + 1
            climber.over.append((why, command, case, cost))
            folder = self.save(f"{family.name}-{number}".replace(": ", "-").replace(" ", "-"), case, cost, smallest)
        print(f"OVER THE LIMIT ({why}): {family.name}: {cost.seconds:.2f} s, {cost.mebibytes:.0f} MiB, ended with {cost.end}: {folder}", flush=True)

    def is_still_over(self, family, genome, why):
        return time.monotonic() < self.until and self.confirmed(family.build(genome), why, 1) is not None

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


def main():
    options = arguments()
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
    except KeyboardInterrupt:
        search.until = 0
    finally:
        found = search.report(baseline)
        search.runner.close()
    sys.exit(2 if search.failure else 1 if found else 0)


if __name__ == "__main__":
    main()
