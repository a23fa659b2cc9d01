"""A short check of an installed package, for every version of Python: `installed.py ROOT`."""

from __future__ import annotations

import sys
from pathlib import Path

import longstep

root = Path(sys.argv[1])
assert root not in Path(longstep.__file__).parents, f"{longstep.__file__} is not the installed package"
world = longstep.World(root / "examples" / "environments" / "pantry.json")
plan = longstep.solve(world, "put(juice, shelf top)").verified()
assert len(plan) == 6, plan
run = longstep.run(plan, longstep.Sim(world), approve="never")
assert run.is_done, run
session = longstep.Session(world, lambda request: '{"goal": "put(juice, shelf top)", "left_out": [], "question": ""}')
assert session.instruct("Put the juice on top of the shelf").verified().pddl() == plan.pddl()
try:
    longstep.solve(world, "put(juice, moon)")
except longstep.Unreadable as error:
    assert "moon" in str(error)
else:
    raise AssertionError("a goal with an unknown name was read")
print(f"Python {sys.version_info.major}.{sys.version_info.minor}: {plan!r}, {run!r}")
