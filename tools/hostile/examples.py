"""Families that vary the repository's own example files, byte by byte and piece by piece."""

import os
import re

from genes import LARGEST
from measure import Case

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
PIECE = re.compile(r"\w+|\s+|.", re.S)
ODD = ("(", ")", "[", "]", "{", "}", '"', "'", "\n", "    ", ",", "\\", "0", "-1", "999999999", "1e308", "\u202e", "\u00e9", "\x1b[", "<", ">", "not ", " and ", "if ", "while ", "forall ", "exists ", "{{", "%}")


def text(path):
    with open(os.path.join(ROOT, path), encoding="utf-8") as file:
        return file.read()


def folder(path, below):
    """The files of a folder, as a case has them."""
    found = {}
    for at, _, names in sorted(os.walk(os.path.join(ROOT, path))):
        for name in sorted(names):
            inside = os.path.join(os.path.relpath(at, os.path.join(ROOT, path)), name)
            found[os.path.normpath(os.path.join(below, inside))] = text(os.path.join(at, name))
    return {name: content for name, content in found.items() if len(content.encode()) <= LARGEST}


def starts():
    """Cases to begin from: (name, case, files that are varied)."""
    garden = folder("examples/greenhouse", "d")
    world = ("--env", "d/environment.json", "--domain", "d")
    stored = folder("examples/stored", "stored")
    plan = {"plan.json": text("examples/plans/warm_cupcake.json"), "reply.txt": text("examples/plans/tidy_magazine.txt"), "env.json": text("crates/longstep-eval/suites/kitchen/scenes/studio.json"), "larder.json": text("examples/environments/larder.json")}
    home = ("--env", "env.json", "--domain", "virtualhome")
    office = {"env.json": text("crates/longstep-eval/suites/branching/scenes/pantry.json"), "plan.py": text("examples/stored/cream.py")}
    yield "domain check", Case(garden, ("domain", "check", "d"))
    yield "domain show", Case(garden, ("domain", "show", "d"))
    yield "solve in a domain", Case(garden, ("solve", "--goal", "watered(tomato) & aired(north bed)", *world))
    yield "verify", Case(plan, ("verify", "plan.json", *home))
    yield "repair", Case(plan, ("repair", "plan.json", *home))
    yield "repair a reply", Case(plan, ("repair", "reply.txt", *home))
    yield "compose", Case({**stored, "larder.json": plan["larder.json"]}, ("compose", "--script", "stored/cream.py", "--plans", *sorted(name for name in stored if name.endswith("json")), "--env", "larder.json", "--domain", "household-checks"))
    yield "verify a script", Case(office, ("verify", "plan.py", "--env", "env.json", "--domain", "household-checks"))
    suite = folder("crates/longstep-eval/suites/branching", "s")
    yield "robot check", Case({"robot.toml": text("examples/robots/ros2/robot.toml"), "env.json": text("examples/environments/pantry.json")}, ("robot", "check", "robot.toml", "--offline", "--env", "env.json"))
    yield "see", Case({"boxes.json": text("examples/see/shelf.boxes.json")}, ("see", "boxes.json", "--json"))
    yield "domain new", Case({"d.pddl": text("examples/greenhouse/domain.pddl")}, ("domain", "new", "made", "--pddl", "d.pddl"))
    yield "suite", Case({**suite, "r.json": "[]"}, ("eval", "s", "--replies", "r.json", "--out", "run"))


class Examples:
    """A family whose genomes are cases; they are varied piece by piece."""

    def __init__(self, name, case):
        self.name = f"bytes: {name}"
        self.case = case

    def build(self, genome):
        return genome

    def draw(self, rng):
        return self.vary(self.case, rng)

    def cross(self, one, other, rng):
        return Case({name: rng.choice((one, other)).files[name] for name in one.files}, one.argv)

    def vary(self, case, rng):
        name = rng.choice(sorted(case.files))
        pieces = PIECE.findall(case.files[name])
        for _ in range(rng.choice((1, 1, 2, 4, 8))):
            pieces = self.edited(pieces, rng)
        changed = "".join(pieces)
        if len(changed.encode("utf-8", "surrogateescape")) > LARGEST:
            return None
        return Case({**case.files, name: changed}, case.argv)

    @staticmethod
    def edited(pieces, rng):
        if not pieces:
            return [rng.choice(ODD)]
        at, length = rng.randrange(len(pieces)), int(len(pieces) ** rng.random())
        part = pieces[at : at + length]
        kind = rng.randrange(6)
        if kind == 0:
            return pieces[:at] + pieces[at + length :]
        if kind == 1:
            return pieces[:at] + part * rng.choice((2, 3, 10, 100)) + pieces[at + length :]
        if kind == 2:
            to = rng.randrange(len(pieces))
            return pieces[:to] + part + pieces[to:]
        if kind == 3:
            return pieces[:at] + [rng.choice(ODD)] * rng.choice((1, 1, 10, 1000)) + pieces[at:]
        if kind == 4:
            return pieces[:at] + [rng.choice(ODD)] + pieces[at + 1 :]
        same = rng.choice(pieces)
        return pieces[:at] + [same] + pieces[at + 1 :]

    def smaller(self, case):
        """The case with parts of its files left out, large parts first."""
        for name in sorted(case.files):
            content = case.files[name]
            length = len(content) // 2
            while length >= 1 and length * 16 >= len(content):
                for at in range(0, len(content), length):
                    yield Case({**case.files, name: content[:at] + content[at + length :]}, case.argv)
                length //= 2


FAMILIES = [Examples(name, case) for name, case in starts()]
