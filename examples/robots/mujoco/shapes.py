"""Shapes of entities, from their names: the geometry that an environment file does not state."""

# Group bits of collisions. Furniture does not collide with furniture, and the hand does not push items: it grasps them.
FURNITURE = 'contype="1" conaffinity="0"'
ITEM = 'contype="2" conaffinity="3"'
HAND = 'contype="0" conaffinity="1"'
NOTHING = 'contype="0" conaffinity="0"'

WALL = 0.01
TABLE_HEIGHT = 0.40
SHELF_GAP = 0.28

# The words of names that decide the shape, as in the `[[derive]]` tables of the household domain.
HANDLES = ("_handle", "_door", "_lid")
SLIDERS = ("drawer_handle", "slider_handle", "sliding_door_handle", "slider")
BINS = ("bin", "trash", "trashcan", "wastebasket", "garbage_can", "dustbin")
BOXES = ("basket", "box", "crate", "bag", "bucket")
PLATES = ("plate", "tray", "dish", "mat", "coaster")
PANES = ("window", "wall", "mirror", "whiteboard", "blackboard")
ROUND = ("juice", "can", "bottle", "cup", "mug", "glass", "jar", "milk", "soda", "beer", "coffee")

COLOURS = [
    (0.85, 0.35, 0.15), (0.20, 0.35, 0.75), (0.85, 0.70, 0.15), (0.30, 0.60, 0.30), (0.60, 0.30, 0.60),
    (0.25, 0.60, 0.65), (0.75, 0.45, 0.50), (0.45, 0.40, 0.30),
]


def bare(name):
    """The identifier without its brackets, in lower case."""
    return name.strip("<>").lower()


def says(name, words):
    """True if the name ends with one of the words: `trash_bin` with `bin`, `table1` with `table`, `wall_shelf` not with
    `wall`."""
    text = "_" + bare(name).rstrip("0123456789").rstrip("_")
    return any(text.endswith("_" + word) for word in words)


def owner(name, entities):
    """The entity that a handle belongs to: `<fridge>` for `<fridge_handle>`; none if it belongs to none."""
    for ending in HANDLES:
        if bare(name).endswith(ending):
            for other in entities:
                if bare(other) == bare(name)[: -len(ending)]:
                    return other
    return None


def slides(name, properties):
    """True if a handle slides, false if it turns."""
    if "SLIDES" in properties or "ROTATES" in properties:
        return "SLIDES" in properties
    return says(name, SLIDERS)


def geom(kind, position, size, colour, bits, extra=""):
    """A geom of MJCF."""
    x, y, z = position
    numbers = " ".join(f"{value:.4f}" for value in size)
    red, green, blue = colour[:3]
    alpha = colour[3] if len(colour) > 3 else 1
    return (f'<geom type="{kind}" pos="{x:.4f} {y:.4f} {z:.4f}" size="{numbers}" '
            f'rgba="{red} {green} {blue} {alpha}" {bits} {extra}/>')


def box(low, high, colour, bits=FURNITURE, extra=""):
    """A box between two corners."""
    centre = [(a + b) / 2 for a, b in zip(low, high)]
    half = [(b - a) / 2 for a, b in zip(low, high)]
    return geom("box", centre, half, colour, bits, extra)


def tub(half, height, colour, bits, extra=""):
    """The geoms of a box that is open at the top. Its origin is the centre of its underside."""
    x, y = half
    return [
        box((-x, -y, 0), (x, y, WALL), colour, bits, extra),
        box((-x, -y, 0), (-x + WALL, y, height), colour, bits, extra),
        box((x - WALL, -y, 0), (x, y, height), colour, bits, extra),
        box((-x, -y, 0), (x, -y + WALL, height), colour, bits, extra),
        box((-x, y - WALL, 0), (x, y, height), colour, bits, extra),
    ]


class Item:
    """An object that can be carried: its geoms around its origin, and its half extents."""

    def __init__(self, name, properties, colour):
        self.name = name
        self.container = False
        # Friction against rolling keeps what falls within reach.
        extra = 'condim="6" friction="1 0.02 0.004" density="400"'
        if "CONTAINER" in properties or says(name, BOXES):
            self.half, self.container = (0.11, 0.09, 0.05), True
            self.geoms = [g for g in tub(self.half[:2], 0.1, colour, ITEM, extra)]
            self.origin = 0.0
        elif "BASE" in properties or says(name, PLATES):
            self.half, self.origin = (0.09, 0.09, 0.008), 0.008
            self.geoms = [geom("cylinder", (0, 0, 0), (0.09, 0.008), colour, ITEM, extra)]
        elif says(name, ROUND):
            self.half, self.origin = (0.03, 0.03, 0.05), 0.05
            self.geoms = [geom("cylinder", (0, 0, 0), (0.03, 0.05), colour, ITEM, extra)]
        else:
            self.half, self.origin = (0.045, 0.03, 0.025), 0.025
            self.geoms = [geom("box", (0, 0, 0), self.half, colour, ITEM, extra)]
