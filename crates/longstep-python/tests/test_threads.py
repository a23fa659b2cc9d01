"""The interpreter is free during searches, and memory does not grow."""

from __future__ import annotations

import gc
import os
import threading
import time
import unittest

import longstep
from scenes import ROOT, desk, reply

CAFE = ROOT / "crates" / "longstep-eval" / "suites" / "long" / "scenes" / "cafe.json"
# A second or more of work: the proof that no plan is shorter ends at its limit.
LONG_GOAL = (
    "put(syrup, window table) & put(lemon, corner table) & put(napkins, counter) & put(vase, wall shelf) & "
    "put(quiche, counter) & put(sugar, wall shelf) & put(spoons, window table)"
)

# Each tick needs the interpreter once. A call that held it would let none through but one or two at its ends.
TICKS = 50

CALLS = 1_000
# Growth of the resident memory over the calls, in bytes: the allocator may keep some pages, and nothing is kept for a call.
GROWTH = 4 * 1024 * 1024


class Threads(unittest.TestCase):
    def test_two_searches_run_while_a_third_thread_makes_progress(self) -> None:
        world = longstep.World(CAFE)
        inside = 0
        lock = threading.Lock()
        done = threading.Event()
        both = most = 0
        answers: list[longstep.Answer] = []

        def search() -> None:
            nonlocal inside, most
            for _ in range(5):
                with lock:
                    inside += 1
                    before = both
                answer = longstep.solve(world, LONG_GOAL)
                with lock:
                    inside -= 1
                    most = max(most, both - before)
                answers.append(answer)
                if most >= TICKS:
                    break

        def tick() -> None:
            nonlocal both
            while not done.is_set():
                with lock:
                    both += inside == 2
                time.sleep(0.001)

        ticker = threading.Thread(target=tick)
        searches = [threading.Thread(target=search) for _ in range(2)]
        ticker.start()
        for thread in searches:
            thread.start()
        for thread in searches:
            thread.join()
        done.set()
        ticker.join()
        self.assertGreaterEqual(most, TICKS)
        self.assertEqual({answer.verified().pddl() for answer in answers}, {answers[0].verified().pddl()})

    def test_worlds_and_plans_are_shared_by_threads(self) -> None:
        world = desk()
        plan = longstep.solve(world, "put(pen, shelf)").verified()
        expected = (plan.json(), plan.svg(), plan.hash)
        found: list[tuple[str, str, str]] = []

        def work() -> None:
            for _ in range(20):
                own = longstep.verify(plan, world).verified()
                found.append((own.json(), plan.svg(), own.hash))

        threads = [threading.Thread(target=work) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(len(found), 80)
        self.assertEqual({(svg, own_hash) for _, svg, own_hash in found}, {expected[1:]})

    @unittest.skipUnless(os.path.exists("/proc/self/statm"), "the memory of a process is read from /proc")
    def test_a_thousand_calls_do_not_grow(self) -> None:
        world = desk()
        draft = '{"task_cohesion": {"task_sequence": ["grasp_object()"], "object_name": "<pen>"}}'

        def calls() -> None:
            plan = longstep.solve(world, "put(pen, shelf)").verified()
            longstep.verify(plan, world).json()
            longstep.repair(draft, world).dict()
            plan.svg()
            session = longstep.Session(longstep.World(world.json()), lambda _: reply("put(pen, shelf)"))
            session.instruct("The pen belongs on the shelf")
            session.accept()
            longstep.run(plan, longstep.Sim(world), approve="never")
            for wrong in ("put(pencil, shelf)", "put(pen"):
                try:
                    longstep.solve(world, wrong)
                except longstep.Unreadable:
                    pass

        for _ in range(CALLS // 5):
            calls()
        before = resident()
        for _ in range(CALLS):
            calls()
        self.assertLess(resident() - before, GROWTH)


def resident() -> int:
    """The memory of this process in bytes."""
    gc.collect()
    with open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


if __name__ == "__main__":
    unittest.main()
