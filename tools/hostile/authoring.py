"""Families of recordings of a hand, scenes of boxes, and new domains from PDDL and from answers."""

import json
import struct

from genes import Family, choice, size
from measure import Case
from domains import Conditions, USUAL, domain_pddl
from runs import MOVES, WORLD, script_of, world_of


def frames(genes, rng):
    """So many frames of a hand that moves, closes and opens, in a line, in arcs or at random."""
    made = []
    for index in range(genes["frames"]):
        at = index / max(1, genes["frames"])
        angle = at * genes["turns"]
        x, y, z = ((at, 0, 1), (angle % 7 / 7, (angle * angle) % 1, 1), (rng.random(), rng.random(), rng.random()), (0, 0, 0), (49.9, -49.9, 1e-300))[genes["path"]]
        row = {"t": index * 10.0 ** -genes["rate"], "hand": ("right", "left")[genes["hands"] and index % 2], "x": round(x, genes["digits"]), "y": round(y, genes["digits"]), "z": round(z, genes["digits"])}
        if genes["grips"]:
            row["grip"] = index // genes["grips"] % 2
        if genes["stepped"]:
            row["step"] = 1 + index * genes["stepped"] // max(1, genes["frames"]) * (10 ** genes["jumps"])
        if genes["grasps"]:
            row["grasp"] = "power"
        made.append(row)
    return made


def mcap(rows):
    """A small MCAP file without chunks, of JSON messages."""
    text = lambda value: struct.pack("<I", len(value)) + value
    record = lambda opcode, body: bytes([opcode]) + struct.pack("<Q", len(body)) + body
    parts = [b"\x89MCAP0\r\n", record(1, text(b"") + text(b"x")), record(4, struct.pack("<HH", 1, 0) + text(b"/hand") + text(b"json") + struct.pack("<I", 0))]
    for number, row in enumerate(rows):
        stamp = int(row.get("t", 0) * 1e9)
        parts.append(record(5, struct.pack("<HIQQ", 1, number, stamp, stamp) + json.dumps(row).encode()))
    parts += [record(15, struct.pack("<I", 0)), record(2, struct.pack("<QQI", 0, 0, 0)), b"\x89MCAP0\r\n"]
    return b"".join(parts).decode("utf-8", "surrogateescape")


def teach(genes, rng):
    world = world_of(genes, rng)
    rows = frames(genes, rng)
    kind = genes["format"]
    if kind == 0:
        head = list(rows[0]) if rows else ["t", "hand", "x", "y", "z"]
        demo = "\n".join([",".join(head)] + [",".join(str(row[name]) for name in head) for row in rows]) + "\n"
    elif kind == 1:
        demo = json.dumps(rows)
    elif kind == 2:
        demo = "\n".join(map(json.dumps, rows)) + "\n"
    else:
        demo = mcap(rows)
    name = "demo." + ("csv", "json", "jsonl", "mcap")[kind]
    files = {"plan.py": script_of({**genes, "checks": 0}, rng, world), "env.json": json.dumps(world), name: demo}
    one_file = genes["segments"] or genes["stepped"]
    argv = ["teach", "plan.py", "--env", "env.json", "--demo", *[name] * (1 if one_file else genes["files"]), "-o", "skills.json"]
    steps = files["plan.py"].count("(") - files["plan.py"].count("range(")
    if genes["segments"]:
        argv += ["--segments", ",".join(f"{1 + index}:{index}-{index + genes['length']}" for index in range(max(1, min(genes["segments"], steps))))]
    if genes["positions"]:
        files["positions.json"] = json.dumps({(world["objects"] + world["assets"])[index % 3]: [0.1, 10.0 ** (index % 300), 0] for index in range(genes["positions"])})
        argv += ["--positions", "positions.json"]
    if genes["json"]:
        argv.append("--json")
    return Case(files, tuple(argv))


def see(genes, rng):
    """Boxes in rows, towers, in each other, all in one place, or at random."""
    boxes = []
    digits = genes["digits"]
    for index in range(genes["boxes"]):
        one = 1 + index * 0.01
        position, extent = (
            ([index * 2.0, 0, 0.5], [1, 1, 1]), ([0, 0, index + 0.5], [1, 1, 1]), ([0, 0, 0], [one, one, one]), ([0, 0, 0.5], [1, 1, 1]),
            ([rng.random() * 3, rng.random() * 3, rng.random() * 3], [rng.random() + 1e-6] * 3), ([index * 1e-7, 0, index * 0.01], [100, 100, 0.01]), ([99999.0, -99999.0, 0], [1e-6, 100000, 1e-6]),
        )[genes["shape"]]
        name = (f"<b{index}>", f"<box_{index}>", f"<box_{index // 2}{'_handle' * (index % 2)}>", f"<{'x' * 90}{index}>", "<box>")[genes["names"]]
        box = {"name": name, "position": [round(value, digits) for value in position], "size": [max(1e-6, round(value, digits)) for value in extent]}
        if genes["turned"]:
            box["orientation"] = [1, 0, 0, 0] if genes["turned"] == 1 else [0.5, 0.5, 0.5, 0.5] if genes["turned"] == 2 else [0.9, 0.1, 0.3, 0.3]
        if genes["assets"] and index % genes["assets"] == 0:
            box["kind"] = "asset"
        if genes["parts"] and index:
            box["part_of"] = boxes[0]["name"] if genes["parts"] == 1 else boxes[index - 1]["name"]
        if genes["said"]:
            box["states"] = [f"on_something({boxes[rng.randrange(index)]['name']})" if index else "closed()" for _ in range(genes["said"])]
        boxes.append(box)
    scene = {"boxes": boxes, "quaternions": "wxyz"}
    if genes["hands"]:
        scene["hands"] = [{"name": f"hand{index}", "position": [0, 0, 1 + index * 0.1], "closed": False} for index in range(genes["hands"])]
    domain = ("household", "household-checks", "household-dual", "virtualhome")[genes["domain"]]
    return Case({"boxes.json": json.dumps(scene)}, ("see", "boxes.json", "--domain", domain, *(("--json",) if genes["json"] else ("-o", "env.json", "--yes"))))


def word_of(genes, index):
    """The name of a predicate."""
    return f"{('p', 'if', 'all', 'x' * 60)[genes['words']]}{index if genes['words'] != 1 or index else ''}"


def chain(genes, rng):
    """A PDDL domain of actions that lead from one predicate to the next, in one of several orders."""
    count = genes["predicates"]
    types = [f"t{index}" for index in range(genes["types"])]
    declared = " ".join(f"{name} - {'object' if index == 0 or genes['flat'] else types[index - 1 if genes['deep'] else index // 2]}" for index, name in enumerate(types))
    kind = lambda index: f" - {types[index * 7 % len(types)]}" if types else ""
    arity = genes["arity"]
    variables = " ".join(f"?x{place}{kind(place)}" for place in range(arity))
    bare = " ".join(f"?x{place}" for place in range(arity))
    named = lambda index: word_of(genes, index)
    numbers = list(range(genes["actions"]))
    if genes["order"] == 1:
        numbers.reverse()
    if genes["order"] == 2:
        rng.shuffle(numbers)
    actions = []
    for number in numbers:
        before = " ".join(f"({named((number + more) % count)} {bare})" for more in range(genes["needs"]))
        after = " ".join(f"({named((number + 1 + more) % count)} {bare})" for more in range(genes["gives"]))
        taken = " ".join(f"(not ({named((number + more) % count)} {bare}))" for more in range(genes["takes"]))
        actions.append(f"(:action a{number} :parameters ({variables}) :precondition (and {before}) :effect (and {after} {taken}))")
    constants = f"(:constants {' '.join(f'c{index}{kind(index)}' for index in range(genes['constants']))})" if genes["constants"] else ""
    functions = f"(:functions {' '.join(f'(f{index} {variables})' for index in range(genes['functions']))})" if genes["functions"] else ""
    return f"(define (domain k) (:requirements :adl :fluents) (:types {declared}) {constants} (:predicates {' '.join(f'({named(index)} {variables})' for index in range(count))}) {functions}\n" + "\n".join(actions) + ")\n"


def new_chain(genes, rng):
    files, argv = {"k.pddl": chain(genes, rng)}, ["domain", "new", "made", "--pddl", "k.pddl"]
    if genes["objects"]:
        objects = [f"o{index}" for index in range(genes["objects"])]
        facts = " ".join(f"({word_of(genes, index % genes['predicates'])} {' '.join(rng.choice(objects) for _ in range(genes['arity']))})" for index in range(genes["facts"]))
        files["p.pddl"] = f"(define (problem p) (:domain k) (:objects {' '.join(objects)}{' - t0' if genes['types'] == 1 else ''}) (:init {facts}) (:goal (and)))\n"
        argv += ["--problem", "p.pddl"]
    return Case(files, tuple(argv))


def new_domain(genes, rng):
    return Case({"d.pddl": domain_pddl(genes, Conditions(genes, rng), rng)}, ("domain", "new", "made", "--pddl", "d.pddl"))


def answers(genes, rng):
    kinds = [f"thing{index}" for index in range(genes["kinds"])]
    lines = ['name = "m"', "kind = [" + ", ".join(f'{{ name = "{name}", stays = {str(index % 2 == 1).lower()}, examples = {json.dumps([f"{name} {at}" for at in range(genes["examples"])])} }}' for index, name in enumerate(kinds)) + "]"]
    fact = lambda: f"the {rng.choice(kinds)} is {('near', 'on', 'at')[rng.randrange(3)] + ' the ' + rng.choice(kinds) if rng.random() < 0.5 else 'state' + str(rng.randrange(1 + genes['states']))}"
    said = []
    for index in range(genes["actions"]):
        words = f"do{index} " + " and ".join(f"a {rng.choice(kinds)}" for _ in range(1 + genes["parameters"]))
        after = [fact() for _ in range(1 + genes["gives"])]
        said += after
        lines += ["[[action]]", f"words = {json.dumps(words)}", f"needs = {json.dumps([fact() for _ in range(genes['needs'])])}", f"then = {json.dumps(after)}"]
    if genes["examples"] and said:
        things = {name: f"{name} {index}" for index, name in enumerate(kinds)}
        named = [" ".join(f"{word} 0" if word in things else word for word in rng.choice(said).split()) for _ in range(genes["start"])]
        lines.insert(2, f"start = {json.dumps(named)}")
    return Case({"answers.toml": "\n".join(lines) + "\n"}, ("domain", "new", "made", "--from", "answers.toml"))


FAMILIES = [
    Family(
        "teach",
        {
            **WORLD, "assets": size(2, 6), "objects": size(1, 12), **MOVES, "frames": size(0, 900), "turns": size(0, 400), "path": choice(5), "rate": size(0, 4), "hands": choice(2), "digits": size(0, 6), "grips": size(0, 60),
            "stepped": size(0, 200), "jumps": size(0, 4), "grasps": choice(2), "format": choice(4), "files": size(1, 30), "segments": size(0, 400), "length": size(1, 100), "positions": size(0, 200), "json": choice(2),
        },
        teach,
    ),
    Family(
        "see",
        {"boxes": size(0, 300), "shape": choice(7), "names": choice(5), "digits": size(0, 8), "turned": choice(4), "assets": size(0, 12), "parts": choice(3), "said": size(0, 40), "hands": size(0, 200), "domain": choice(4), "json": choice(2)},
        see,
    ),
    Family(
        "domain-new",
        {
            "predicates": size(1, 400), "types": size(0, 300), "flat": choice(2), "deep": choice(2), "arity": size(0, 7), "actions": size(1, 250), "order": choice(3), "needs": size(0, 30), "gives": size(1, 30), "takes": size(0, 10),
            "constants": size(0, 400), "functions": size(0, 60), "words": choice(4), "objects": size(0, 300), "facts": size(0, 600),
        },
        new_chain,
    ),
    Family("domain-new-chain", {"predicates": size(1, 400), "types": size(0, 3), "flat": choice(2), "deep": choice(2), "arity": size(1, 2), "actions": size(1, 250), "order": choice(3), "needs": size(1, 2), "gives": size(1, 2), "takes": size(0, 1), "constants": size(0, 3), "functions": size(0, 3), "words": choice(1), "objects": size(0, 0), "facts": size(0, 0)}, new_chain),
    Family("domain-new-conditions", {**USUAL, "actions": size(1, 60)}, new_domain),
    Family("domain-new-answers", {"kinds": size(1, 120), "examples": size(0, 60), "states": size(0, 200), "start": size(0, 300), "actions": size(1, 150), "parameters": size(0, 6), "needs": size(0, 30), "gives": size(0, 30)}, answers),
]
