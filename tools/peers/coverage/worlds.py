"""Random first states of eight domains, and goals where any combination can be reached."""

from dataclasses import dataclass, field
from random import Random

Fact = tuple[str, ...]


@dataclass
class Start:
    """Objects by type, the facts of the first state, and a goal if the domain guarantees that it can be reached."""

    objects: dict[str, list[str]]
    facts: list[Fact]
    goal: list[Fact] = field(default_factory=list)


def numbered(stem: str, count: int) -> list[str]:
    """Names such as `tube1`."""
    return [f"{stem}{number}" for number in range(1, count + 1)]


def lab(random: Random) -> Start:
    """Tubes in racks, and closed or open centrifuges."""
    tubes, racks = numbered("tube", random.randint(2, 6)), numbered("rack", random.randint(1, 3))
    centrifuges = numbered("centrifuge", random.randint(1, 2))
    facts = [("at", random.choice(racks)), ("hand-free",)]
    for tube in tubes:
        facts.append(("in", tube, random.choice(racks)))
        facts += [(word, tube) for word in ("capped", "filled") if random.random() < 0.5]
    facts += [("lid-open", centrifuge) for centrifuge in centrifuges if random.random() < 0.3]
    return Start({"tube": tubes, "rack": racks, "centrifuge": centrifuges}, facts, [("spun", tube) for tube in tubes])


def logistics(random: Random) -> Start:
    """Cities with an airport and a truck each."""
    cities = numbered("city", random.randint(1, 4))
    airports, places, trucks, facts = [], [], [], []
    for city in cities:
        own = [f"{city}-place{number}" for number in range(1, random.randint(1, 3) + 1)]
        airports.append(f"{city}-airport")
        places += own
        trucks.append(f"{city}-truck")
        facts += [("in-city", place, city) for place in [*own, airports[-1]]]
        facts.append(("at-vehicle", trucks[-1], random.choice([*own, airports[-1]])))
    planes = numbered("plane", random.randint(1, 2))
    parcels = numbered("parcel", random.randint(2, 7))
    facts += [("at-vehicle", plane, random.choice(airports)) for plane in planes]
    everywhere = places + airports
    facts += [("at-parcel", parcel, random.choice(everywhere)) for parcel in parcels]
    goal = [("at-parcel", parcel, random.choice(everywhere)) for parcel in parcels]
    kinds = {"truck": trucks, "plane": planes, "parcel": parcels, "place": places, "airport": airports, "city": cities}
    return Start(kinds, facts, goal)


def towers(blocks: list[str], random: Random) -> list[Fact]:
    """A random arrangement of all blocks."""
    facts: list[Fact] = []
    tops: list[str] = []
    for block in random.sample(blocks, len(blocks)):
        place = random.randint(0, len(tops))
        if place == len(tops):
            facts.append(("on-table", block))
            tops.append(block)
        else:
            facts.append(("on", block, tops[place]))
            tops[place] = block
    return facts + [("clear", block) for block in tops]


def blocks(random: Random) -> Start:
    """Towers of blocks."""
    names = numbered("block", random.randint(3, 13))
    goal = [fact for fact in towers(names, random) if fact[0] == "on"]
    return Start({"block": names}, [*towers(names, random), ("hand-empty",)], goal)


def household(random: Random) -> Start:
    """Furniture with doors and drawers, and things in and on it."""
    assets, items, facts, places = [], [], [], []
    for asset in ("table", "shelf", "counter")[: random.randint(1, 3)]:
        assets.append(asset)
        places.append(("on", asset))
        facts.append(("base", asset))
    for asset in ("fridge", "drawer", "cupboard")[: random.randint(1, 3)]:
        handle = f"{asset}-handle"
        assets.append(asset)
        items.append(handle)
        turn = "slides" if asset == "drawer" else "rotates"
        facts += [("can-open", asset), ("handle-of", handle, asset), ("container", asset), ("base", asset)]
        facts += [("fixed", handle), (turn, handle), (random.choice(["open", "open", "closed"]), handle)]
        places.append(("inside", asset))
    if random.random() < 0.5:
        assets.append("bin")
        facts += [("bin", "bin"), ("container", "bin")]
    things = ["cup", "plate", "juice", "sponge", "pan", "bread"][: random.randint(1, 6)]
    items += things
    for thing in things:
        relation, place = random.choice(places)
        facts.append((relation, thing, place))
    goal = [(relation, thing, place) for thing in things for relation, place in [random.choice(places)]]
    return Start({"asset": assets, "item": items}, facts, goal)


def grid(random: Random, smallest: int, largest: int, gap: float) -> tuple[list[tuple[int, int]], dict]:
    """Connected cells of a rectangle with gaps, and the cell beyond each in each direction."""
    width, height = random.randint(smallest, largest), random.randint(smallest, largest)
    cells = [(x, y) for x in range(width) for y in range(height) if random.random() >= gap]
    moves = {"right": (1, 0), "left": (-1, 0), "down": (0, 1), "up": (0, -1)}
    best: set[tuple[int, int]] = set()
    for cell in cells:
        part, queue = {cell}, [cell]
        while queue:
            x, y = queue.pop()
            near = [(x + a, y + b) for a, b in moves.values() if (x + a, y + b) in cells]
            queue += [other for other in near if other not in part]
            part.update(near)
        best = part if len(part) > len(best) else best
    steps = {(cell, name): (cell[0] + a, cell[1] + b) for cell in best for name, (a, b) in moves.items()}
    return sorted(best), {key: to for key, to in steps.items() if to in best}


def cell_name(cell: tuple[int, int]) -> str:
    """The name of a cell."""
    return f"cell-{cell[0]}-{cell[1]}"


def keys(random: Random) -> Start:
    """A grid with locked cells, and keys that lie in open ones."""
    cells, steps = grid(random, 4, 9, 0.15)
    shapes = numbered("shape", random.randint(1, 3))
    names = numbered("key", random.randint(len(shapes), 5))
    locked = [cell for cell in cells if random.random() < 0.25][: len(cells) - 2]
    free = [cell for cell in cells if cell not in locked]
    facts = [("at", cell_name(random.choice(free))), ("hand-free",)]
    facts += [("next-to", cell_name(cell), cell_name(to)) for (cell, _), to in steps.items()]
    for cell in locked:
        facts += [("locked", cell_name(cell)), ("lock", cell_name(cell), random.choice(shapes))]
    for key in names:
        facts += [("fits", key, random.choice(shapes)), ("lies", key, cell_name(random.choice(free)))]
    return Start({"cell": [cell_name(cell) for cell in cells], "key": names, "shape": shapes}, facts)


def pushing(random: Random) -> Start:
    """A grid with crates."""
    cells, steps = grid(random, 5, 8, 0.1)
    crates = numbered("crate", random.randint(1, 5))
    taken = random.sample(cells, len(crates) + 1)
    facts = [("at", cell_name(taken[-1]))]
    facts += [("step", cell_name(cell), cell_name(to), name) for (cell, name), to in steps.items()]
    facts += [("stands", crate, cell_name(cell)) for crate, cell in zip(crates, taken)]
    facts += [("empty", cell_name(cell)) for cell in cells if cell not in taken[:-1]]
    directions = ["right", "left", "down", "up"]
    return Start({"cell": [cell_name(cell) for cell in cells], "direction": directions, "crate": crates}, facts)


def lifts(random: Random) -> Start:
    """Lifts of several sizes; the first one stops everywhere."""
    floors = numbered("floor", random.randint(4, 10))
    names = numbered("lift", random.randint(1, 3))
    passengers = numbered("passenger", random.randint(2, 9))
    seats, facts = [], []
    for lift in names:
        stops = floors if lift == names[0] else random.sample(floors, max(2, len(floors) // 2))
        facts += [("stops", lift, floor) for floor in stops] + [("at-floor", lift, random.choice(stops))]
        own = [f"{lift}-seat{number}" for number in range(1, random.randint(1, 3) + 1)]
        seats += own
        facts += [fact for seat in own for fact in (("seat-of", seat, lift), ("free", seat))]
    facts += [("waits", passenger, random.choice(floors)) for passenger in passengers]
    goal = [("waits", passenger, random.choice(floors)) for passenger in passengers]
    return Start({"lift": names, "seat": seats, "passenger": passengers, "floor": floors}, facts, goal)


def assembly(random: Random) -> Start:
    """Parts that lie at stations, some of them fitted already in the wrong order."""
    parts, tools = numbered("part", random.randint(2, 8)), numbered("tool", random.randint(1, 3))
    stations = numbered("station", random.randint(2, 5))
    facts = [("at", random.choice(stations)), ("hand-free",), ("fixture", stations[0])]
    for index, part in enumerate(parts):
        facts.append(("joined-with", part, random.choice(tools)))
        below = [other for other in parts[:index] if random.random() < 0.3]
        facts += [("needs", part, other) for other in below]
        blocked = [other for other in parts[:index] if other not in below and random.random() < 0.2]
        facts += [("blocks", part, other) for other in blocked]
        needs = {fact[2] for fact in facts if fact[0] == "needs" and fact[1] == part}
        if random.random() < 0.25 and not needs:
            facts += [("part-at", part, stations[0]), ("placed", part), ("fitted", part)]
        else:
            facts.append(("part-at", part, random.choice(stations)))
    facts += [("tool-at", tool, random.choice(stations)) for tool in tools]
    # A part that blocks another is fitted after it, so the order of the parts is a plan.
    return Start({"part": parts, "tool": tools, "station": stations}, facts, [("fitted", part) for part in parts])


DOMAINS = (lab, logistics, blocks, household, keys, lifts, pushing, assembly)
