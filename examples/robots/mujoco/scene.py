"""A scene from an environment file: furniture in a row, joints for what opens, free bodies for what can be carried."""

import shapes
from shapes import FURNITURE, NOTHING, SHELF_GAP, TABLE_HEIGHT, WALL, bare, box, geom, says, tub

WOOD, METAL, WHITE, GLASS = (0.62, 0.48, 0.34), (0.45, 0.48, 0.52), (0.88, 0.89, 0.90), (0.6, 0.8, 0.95, 0.5)

# The hand travels in a plane in front of everything, also of open doors.
CORRIDOR = -1.15
APART, BESIDE = 0.45, 0.04
# Degrees and metres.
DOOR_RANGE, DRAWER_RANGE = 110, 0.3
# The shares of these ranges that are narrow and wide. Also the narrow ones leave room for the hand and what it carries.
DOOR_SHARES, DRAWER_SHARES = (0.72, 0.88), (0.7, 0.95)


class Place:
    """Where items can be put: a region in the frame of a body, and the side from which the hand gets there."""

    def __init__(self, body, low, high, surface, approach, container, upright=False, interior=None):
        self.body, self.low, self.high, self.surface = body, low, high, surface
        self.approach, self.container, self.upright = approach, container, upright
        # The space within the walls of a container: larger than the region in which items are put.
        self.interior = interior or (low, high)


class Handle:
    """A handle: the body that it moves, and its joint."""

    def __init__(self, name, body, joint, reach, slides):
        self.name, self.body, self.joint, self.reach, self.slides = name, body, joint, reach, slides
        self.narrow, self.wide = DRAWER_SHARES if slides else DOOR_SHARES


def statements(environment, name):
    """The states of an entity as pairs of word and argument."""
    found = []
    for states in (environment.get("asset_states", {}), environment.get("object_states", {})):
        words = states.get(name, [])
        for word in [words] if isinstance(words, str) else words:
            call, _, rest = word.partition("(")
            found.append((call.strip(), rest.rstrip(")").strip()))
    return found


def properties(environment, name):
    """The properties of an entity."""
    found = []
    for key in ("asset_properties", "object_properties"):
        words = (environment.get(key) or {}).get(name, [])
        found += [words] if isinstance(words, str) else words
    return found


class Scene:
    """The model of a scene as MJCF, with what the robot knows about its parts."""

    def __init__(self, environment):
        self.environment = environment
        self.assets = list(environment.get("assets", []))
        self.objects = list(environment.get("objects", []))
        self.places, self.handles, self.items, self.boards = {}, {}, {}, {}
        self.bodies, self.equalities, self.free = [], [], []
        self.extent = {}
        entities = self.assets + self.objects
        self.owned = {}
        for name in self.objects:
            of = shapes.owner(name, entities)
            if of is not None:
                self.owned[of] = name
        self.floor = next((name for name in self.assets if says(name, ("floor", "ground"))), None)
        self.furniture()
        self.carried()

    def where(self, name):
        """The entity that another one is on or in; none if the environment does not say."""
        for word, other in statements(self.environment, name):
            if word in ("on_something", "inside_something"):
                return other
        return None

    def neighbours(self, name):
        """The entities that another one stands next to."""
        return [other for word, other in statements(self.environment, name) if word == "next_to"]

    def row(self):
        """The furniture on the floor, so ordered that neighbours stand side by side."""
        standing = [name for name in self.assets
                    if name != self.floor and self.where(name) in (None, self.floor) and not self.board_above(name)]
        ordered = []
        for name in standing:
            if name in ordered:
                continue
            ordered.append(name)
            for other in self.neighbours(name):
                if other in standing and other not in ordered:
                    ordered.append(other)
        return ordered

    def board_above(self, name):
        """The board under the upper board of a shelf, if the environment does not place the upper one."""
        if self.where(name) is not None or not bare(name).endswith("_top"):
            return None
        below = bare(name)[:-4] + "_bottom"
        return next((other for other in self.assets if bare(other) == below), None)

    def furniture(self):
        """Builds everything that stays where it is."""
        if self.floor is not None:
            self.places[self.floor] = Place("world", (-3, CORRIDOR + 0.15, 0), (3, -0.75, 0.6), 0, "top", False)
        right, last = 0.0, None
        for name in self.row():
            width = 0.6 if name not in self.owned else 0.5
            if says(name, shapes.BINS):
                width = 0.36
            near = last is not None and (name in self.neighbours(last) or last in self.neighbours(name))
            right += 0 if last is None else BESIDE if near else APART
            self.stand(name, right + width / 2, width)
            right, last = right + width, name
        self.width = right
        for name in self.assets:
            if name not in self.places and self.where(name) not in (None, self.floor):
                self.board(name, self.where(name))
        for name in self.assets:
            below = self.board_above(name)
            if name not in self.places and below is not None:
                self.upper_board(name, below)
        for name in self.assets:
            if name not in self.places:
                raise ValueError(f"{name} stands on {self.where(name)}, which stands on nothing")

    def add(self, name, position, parts, inner=""):
        """Adds a body that does not move."""
        x, y, z = position
        body = bare(name)
        self.bodies.append(f'<body name="{body}" pos="{x:.4f} {y:.4f} {z:.4f}">{"".join(parts)}{inner}</body>')

    def stand(self, name, x, width):
        """Builds a piece of furniture on the floor."""
        half, body = width / 2, bare(name)
        handle = self.owned.get(name)
        if handle is not None and shapes.slides(handle, properties(self.environment, handle)):
            self.drawer(name, handle, x, half)
        elif handle is not None:
            self.cabinet(name, handle, x, half)
        elif says(name, shapes.BINS) or "BIN" in properties(self.environment, name):
            self.add(name, (x, 0, 0), tub((half, half), 0.3, METAL, FURNITURE))
            self.places[name] = Place(body, (-half + 0.05, -half + 0.05, 0), (half - 0.05, half - 0.05, 0.3), WALL, "top", True,
                                      interior=((-half, -half, 0), (half, half, 0.3)))
        elif says(name, shapes.PANES) or "UPRIGHT" in properties(self.environment, name):
            pane = [box((-half, 0, 0.35), (half, 0.03, 1.0), GLASS), box((-half, 0, 0), (half, 0.03, 0.35), WHITE)]
            self.add(name, (x, 0.1, 0), pane)
            self.places[name] = Place(body, (-half + 0.1, -0.2, 0.5), (half - 0.1, 0, 0.9), 0, "front", False, upright=True)
        else:
            self.table(name, x, half)
        self.extent[name] = (x - half, x + half)

    def table(self, name, x, half):
        """Builds a table: the shape of everything that has no other one."""
        under = TABLE_HEIGHT - 0.03
        corners = [(sx * (half - 0.02), sy * 0.23) for sx in (-1, 1) for sy in (-1, 1)]
        legs = [box((x - 0.02, y - 0.02, 0), (x + 0.02, y + 0.02, under), WOOD) for x, y in corners]
        self.add(name, (x, 0, 0), legs + [box((-half, -0.25, under), (half, 0.25, TABLE_HEIGHT), WOOD)])
        low, high = (-half + 0.06, -0.21, TABLE_HEIGHT), (half - 0.06, 0.19, TABLE_HEIGHT + 0.3)
        container = "CONTAINER" in properties(self.environment, name)
        self.places[name] = Place(bare(name), low, high, TABLE_HEIGHT, "top", container)

    def cabinet(self, name, handle, x, half):
        """Builds a box with a hinged door: a fridge, an oven, a cupboard."""
        body, depth, low, high = bare(name), 0.25, 0.3, 0.85
        shell = [
            box((-half, -depth, 0), (half, depth, low), WHITE),
            box((-half, -depth, high), (half, depth, high + 0.02), WHITE),
            box((-half, -depth, low), (-half + 0.02, depth, high), WHITE),
            box((half - 0.02, -depth, low), (half, depth, high), WHITE),
            box((-half, depth - 0.02, low), (half, depth, high), WHITE),
        ]
        width, grip = 2 * half, 2 * half - 0.06
        door = (f'<body name="{bare(handle)}" pos="{-half:.4f} {-depth - 0.012:.4f} {(low + high) / 2:.4f}">'
                f'<joint name="{bare(handle)}" type="hinge" axis="0 0 -1" range="0 {DOOR_RANGE}" damping="0.6" '
                'frictionloss="0.4" armature="0.02"/>'
                + box((0, -0.01, -0.275), (width, 0.01, 0.275), WHITE, extra='mass="1.5"')
                + geom("capsule", (grip, -0.06, 0), (0.01, 0.08), METAL, NOTHING, 'mass="0.1"') + "</body>")
        self.add(name, (x, 0, 0), shell, door)
        self.handles[handle] = Handle(handle, bare(handle), bare(handle), (grip, -0.06, 0), False)
        self.places[name] = Place(body, (-0.02, -0.18, low), (half - 0.09, 0.1, high), low, "front", True,
                                  interior=((-half, -depth, low), (half, depth, high)))

    def drawer(self, name, handle, x, half):
        """Builds a chest with a sliding drawer. The drawer is the place: what lies in it moves with it."""
        depth, low, high = 0.25, 0.3, 0.5
        tray = f"{bare(name)}_tray"
        shell = [
            box((-half, -depth, 0), (half, depth, low - 0.01), WOOD),
            box((-half, -depth, high), (half, depth, high + 0.02), WOOD),
            box((-half, -depth, low - 0.01), (-half + 0.02, depth, high), WOOD),
            box((half - 0.02, -depth, low - 0.01), (half, depth, high), WOOD),
        ]
        inner = half - 0.03
        parts = tub((inner, depth - 0.02), 0.12, (0.75, 0.62, 0.45), FURNITURE, 'mass="0.2"')
        front = box((-half, -depth - 0.005, -0.01), (half, -depth + 0.012, 0.2), WOOD, extra='mass="0.3"')
        grip = geom("capsule", (0, -depth - 0.055, 0.1), (0.01, 0.05), METAL, NOTHING, 'mass="0.1" euler="0 90 0"')
        body = (f'<body name="{tray}" pos="0 0 {low:.4f}"><joint name="{bare(handle)}" type="slide" axis="0 -1 0" '
                f'range="0 {DRAWER_RANGE}" damping="6" frictionloss="2"/>{"".join(parts)}{front}{grip}</body>')
        self.add(name, (x, 0, 0), shell, body)
        self.handles[handle] = Handle(handle, tray, bare(handle), (0, -depth - 0.055, 0.1), True)
        self.places[name] = Place(tray, (-inner + 0.05, -depth + 0.06, 0), (inner - 0.05, -depth + 0.17, 0.2), WALL, "top", True,
                                  interior=((-inner, -depth, 0), (inner, depth, 0.2)))

    def board(self, name, on):
        """Builds a board, or a small piece of furniture, on another one."""
        if on not in self.places:
            raise ValueError(f"{name} stands on {on}, which is no furniture on the floor")
        below = self.places[on]
        left, right = self.extent[on]
        x, z, half = (left + right) / 2, below.surface, (right - left) / 2 - 0.12
        self.add(name, (x, 0.11, z), [box((-half, -0.12, 0), (half, 0.12, 0.02), WHITE)])
        # What is under it is no room for items any more.
        below.high = (below.high[0], -0.06, below.high[2])
        self.extent[name] = (x - half, x + half)
        covered = any(self.board_above(other) == name for other in self.assets)
        low, high = (-half + 0.06, -0.09, 0.02), (half - 0.06, 0.05, SHELF_GAP)
        self.places[name] = Place(bare(name), low, high, 0.02, "front" if covered else "top", False)
        self.boards[name] = (x, 0.11, z, half)

    def upper_board(self, name, below):
        """Builds the upper board of a shelf on two sides."""
        if below in self.boards:
            x, y, z, half = self.boards[below]
        else:
            (left, right), place = self.extent[below], self.places[below]
            x, y, z, half = (left + right) / 2, 0.11, place.surface, (right - left) / 2
            # The lower board is reached from the front now, and only under the upper one.
            place.approach = "front"
            place.low, place.high = (place.low[0], 0.0, place.low[2]), (place.high[0], 0.15, place.high[2])
        sides = [box((side * half - 0.01, -0.12, 0.02), (side * half + 0.01, 0.12, SHELF_GAP), WHITE) for side in (-1, 1)]
        self.add(name, (x, y, z), sides + [box((-half, -0.12, SHELF_GAP), (half, 0.12, SHELF_GAP + 0.02), WHITE)])
        self.extent[name] = (x - half, x + half)
        top = SHELF_GAP + 0.02
        self.places[name] = Place(bare(name), (-half + 0.06, -0.09, top), (half - 0.06, 0.09, top + 0.3), top, "top", False)

    def carried(self):
        """Builds a free body for each object that is no handle, and handles that belong to nothing as knobs."""
        colours = iter(shapes.COLOURS * (len(self.objects) + 1))
        for name in self.objects:
            if name in self.handles:
                continue
            if name in self.owned.values() or says(name, ("handle", "knob", "lever", "dial", "door")):
                raise ValueError(f"{name} belongs to no furniture of the environment, so the scene has no place for it")
            item = shapes.Item(name, properties(self.environment, name), next(colours))
            self.items[name] = item
            body = bare(name)
            self.free.append(f'<body name="{body}" pos="0 0 -5"><freejoint name="{body}"/>{"".join(item.geoms)}</body>')
            self.equalities.append(
                f'<weld name="grasp_{body}" body1="hand" body2="{body}" active="false" solref="0.01 1"/>')
            if item.container or says(name, shapes.PLATES) or "BASE" in properties(self.environment, name):
                x, y, z = item.half
                top = WALL if item.container else z
                self.places[name] = Place(body, (-x + 0.05, -y + 0.05, top), (x - 0.05, y - 0.05, top + 0.2), top, "top", item.container)
        for handle in self.handles.values():
            self.equalities.append(
                f'<connect name="grasp_{bare(handle.name)}" body1="hand" body2="{handle.body}" anchor="0 0 0" '
                'active="false" solref="0.01 1"/>')

    def mjcf(self):
        """The model."""
        hand = (geom("sphere", (0, 0, 0), (0.018,), (0.1, 0.1, 0.1), shapes.HAND, 'mass="0.5"')
                + geom("capsule", (0, -0.06, 0.1), (0.012, 0.12), (0.9, 0.35, 0.1), NOTHING, 'mass="0.01" euler="-30 0 0"'))
        return f"""<mujoco model="longstep">
<compiler angle="degree" autolimits="true"/>
<option timestep="0.002" integrator="implicitfast"/>
<visual><headlight ambient="0.35 0.35 0.35" diffuse="0.3 0.3 0.3" specular="0 0 0"/><global offwidth="640" offheight="480"/><quality shadowsize="1024"/></visual>
<asset><texture name="sky" type="skybox" builtin="gradient" rgb1="0.85 0.9 1" rgb2="1 1 1" width="64" height="64"/></asset>
<worldbody>
<light directional="true" pos="{self.width / 2} -2 3" dir="0.3 0.5 -1" diffuse="0.5 0.5 0.5"/>
<geom name="floor" type="plane" size="6 6 0.1" rgba="0.82 0.82 0.78 1" {FURNITURE}/>
{"".join(self.bodies)}
{"".join(self.free)}
<body name="target" mocap="true" pos="0 {CORRIDOR} 0.8"/>
<body name="hand" pos="0 {CORRIDOR} 0.8" gravcomp="1"><freejoint name="hand"/>{hand}</body>
</worldbody>
<equality><weld name="drive" body1="target" body2="hand" solref="0.01 1"/>{"".join(self.equalities)}</equality>
</mujoco>"""
