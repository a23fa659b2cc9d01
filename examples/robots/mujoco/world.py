"""The running simulation: places items, moves the hand, and measures facts from contacts, positions and joints."""

import numpy as np
import mujoco

import shapes
from scene import CORRIDOR, statements
from shapes import bare

# Two bodies touch if a contact between them is at most this far.
TOUCH = 0.0015
CLOSED, OPEN = 0.03, 0.08
REACH = 0.035


class World:
    """A scene under simulation."""

    def __init__(self, scene):
        self.scene = scene
        self.model = mujoco.MjModel.from_xml_string(scene.mjcf())
        self.data = mujoco.MjData(self.model)
        self.held = self.recorder = None
        self.grip = np.zeros(3)
        mujoco.mj_forward(self.model, self.data)
        self.entity_of = {}
        for name in scene.assets + scene.objects:
            body = scene.handles[name].body if name in scene.handles else bare(name)
            identifier = mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_BODY, body)
            if identifier >= 0:
                self.entity_of[identifier] = name
        for name, place in scene.places.items():
            self.entity_of[self.body(place.body)] = name
        self.begin()

    # --- bodies, joints, geoms ---

    def body(self, name):
        return mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_BODY, name)

    def position(self, name):
        return self.data.xpos[self.body(name)].copy()

    def joint(self, handle):
        return self.model.jnt_qposadr[mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_JOINT, handle.joint)]

    def fraction(self, name):
        """How far a door or drawer is open, from 0 to 1."""
        handle = self.scene.handles[name]
        identifier = mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_JOINT, handle.joint)
        low, high = self.model.jnt_range[identifier]
        return float((self.data.qpos[self.joint(handle)] - low) / (high - low))

    def extents(self, name):
        """The lowest and the highest corner of an item, in the world."""
        identifier = self.body(bare(name))
        low, high = np.full(3, np.inf), np.full(3, -np.inf)
        first = self.model.body_geomadr[identifier]
        for geom in range(first, first + self.model.body_geomnum[identifier]):
            rotation = self.data.geom_xmat[geom].reshape(3, 3)
            size = self.model.geom_size[geom]
            if self.model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_CYLINDER:
                axis = rotation[:, 2]
                half = np.abs(axis) * size[1] + size[0] * np.sqrt(np.maximum(0, 1 - axis**2))
            else:
                half = np.abs(rotation) @ size
            centre = self.data.geom_xpos[geom]
            low, high = np.minimum(low, centre - half), np.maximum(high, centre + half)
        return low, high

    def grip_point(self, name):
        """The point at which the hand grasps an item or a handle."""
        if name in self.scene.handles:
            handle = self.scene.handles[name]
            body = self.body(handle.body)
            return self.data.xpos[body] + self.data.xmat[body].reshape(3, 3) @ np.array(handle.reach)
        low, high = self.extents(name)
        return np.array([(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, high[2] + 0.012])

    def to_world(self, place, point):
        if place.body == "world":
            return np.array(point, float)
        body = self.body(place.body)
        return self.data.xpos[body] + self.data.xmat[body].reshape(3, 3) @ np.array(point, float)

    def interior(self, place):
        """The space within the walls of a container, in the world."""
        low, high = place.interior
        corners = np.array([self.to_world(place, [x, y, z]) for x in (low[0], high[0])
                            for y in (low[1], high[1]) for z in (low[2], high[2])])
        return corners.min(axis=0), corners.max(axis=0)

    # --- the beginning ---

    def begin(self):
        """Puts joints and items where the environment says, and lets them settle."""
        environment = self.scene.environment
        for name, handle in self.scene.handles.items():
            words = [word for word, _ in statements(environment, name)]
            if "open" in words:
                identifier = mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_JOINT, handle.joint)
                self.data.qpos[self.joint(handle)] = handle.narrow * self.model.jnt_range[identifier][1]
        mujoco.mj_forward(self.model, self.data)
        waiting = list(self.scene.items)
        while waiting:
            ready = [name for name in waiting if self.scene.where(name) not in waiting]
            if not ready:
                raise ValueError(f"{waiting[0]} is on something that is on it")
            for name in ready:
                self.place(name, self.scene.where(name) or self.scene.floor)
                waiting.remove(name)
        self.step(400)
        for name in self.scene.items:
            if any(word == "inside_hand" for word, _ in statements(environment, name)):
                self.data.mocap_pos[0] = self.grip_point(name)
                self.data.qpos[self.hand_joint():][:3] = self.grip_point(name)
                mujoco.mj_forward(self.model, self.data)
                self.attach(name)

    def hand_joint(self):
        return self.model.jnt_qposadr[mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_JOINT, "hand")]

    def place(self, name, on):
        """Puts an item on or in a place, before the simulation begins."""
        if on is None:
            raise ValueError(f"{name} is nowhere: the environment has no floor to put it on")
        if on not in self.scene.places:
            raise ValueError(f"{name} is on {on}, on which the scene has no room")
        spot = self.spot(name, on)
        if spot is None:
            raise ValueError(f"there is no room left on {on} for {name}")
        joint = mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_JOINT, bare(name))
        address = self.model.jnt_qposadr[joint]
        self.data.qpos[address:address + 3] = spot + [0, 0, self.scene.items[name].origin + 0.002]
        self.data.qpos[address + 3:address + 7] = [1, 0, 0, 0]
        mujoco.mj_forward(self.model, self.data)

    def spot(self, name, on):
        """A free spot for an item on a place, as a point on its surface; none if there is no room."""
        place = self.scene.places[on]
        width = max(self.scene.items[name].half[:2])
        low, high = np.array(place.low), np.array(place.high)
        columns = max(1, int((high[0] - low[0]) / 0.1) + 1)
        rows = max(1, int((high[1] - low[1]) / 0.1) + 1)
        middle = (low + high) / 2
        spots = [(x, y) for x in np.linspace(low[0], high[0], columns) for y in np.linspace(low[1], high[1], rows)]
        # From the middle outwards, the near ones first; the numbers settle what is equally far.
        spots.append((middle[0], middle[1]))
        spots.sort(key=lambda spot: (round(abs(spot[0] - middle[0]) + abs(spot[1] - middle[1]), 6), spot))
        others = [other for other in self.scene.items if other not in (name, on) and self.position(bare(other))[2] > -1]
        for x, y in spots:
            point = self.to_world(place, [x, y, place.surface])
            boxes = [self.extents(other) for other in others]
            room = width + 0.015
            near = [box for box in boxes if box[1][2] > point[2] - 0.01 and box[0][2] < point[2] + 0.2
                    and box[0][0] - room < point[0] < box[1][0] + room and box[0][1] - room < point[1] < box[1][1] + room]
            if not near:
                return point
        return None

    def step(self, count):
        for _ in range(count):
            mujoco.mj_step(self.model, self.data)
            if self.recorder is not None:
                self.recorder.sample(self)

    # --- the grasp ---

    def hand(self):
        return self.data.xpos[self.body("hand")].copy()

    def equality(self, name):
        return mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_EQUALITY, "grasp_" + bare(name))

    def attach(self, name):
        """Closes the hand around an item or a handle, where both are now."""
        equality, hand = self.equality(name), self.body("hand")
        handle = self.scene.handles.get(name)
        body = self.body(handle.body if handle else bare(name))
        back = np.zeros(4)
        mujoco.mju_negQuat(back, self.data.xquat[hand])
        offset = np.zeros(3)
        data = self.model.eq_data[equality]
        if handle:
            away = np.zeros(4)
            mujoco.mju_negQuat(away, self.data.xquat[body])
            mujoco.mju_rotVecQuat(offset, self.data.xpos[hand] - self.data.xpos[body], away)
            data[:3], data[3:6] = 0, offset
        else:
            mujoco.mju_rotVecQuat(offset, self.data.xpos[body] - self.data.xpos[hand], back)
            turn = np.zeros(4)
            mujoco.mju_mulQuat(turn, back, self.data.xquat[body])
            data[:3], data[3:6], data[6:10], data[10] = 0, offset, turn, 1
        self.data.eq_active[equality] = 1
        self.held, self.grip = name, self.offset(name)

    def offset(self, name):
        """Where the grip point of an item or handle is, seen from the hand."""
        handle = self.scene.handles.get(name)
        return (self.grip_point(name) if handle else self.position(bare(name))) - self.hand()

    def detach(self):
        """Opens the hand."""
        if self.held is not None:
            self.data.eq_active[self.equality(self.held)] = 0
            self.held = None

    def holds(self, name):
        """True if the hand is closed around an item or handle, and it has not left the hand."""
        return self.held == name and float(np.linalg.norm(self.offset(name) - self.grip)) < 0.05

    def pressed(self):
        """How deep the hand, or what it holds, is pressed into something, in metres: the sense of touch."""
        own = {self.body("hand")}
        if self.held in self.scene.items:
            own.add(self.body(bare(self.held)))
        depth = 0.0
        for contact in self.data.contact[: self.data.ncon]:
            bodies = {int(self.model.geom_bodyid[geom]) for geom in contact.geom}
            if len(bodies & own) == 1:
                depth = max(depth, -contact.dist)
        return depth

    # --- measured facts ---

    def contacts(self, name):
        """What an item touches: pairs of the other entity's name (`None` for a handle's body) and the normal towards it."""
        own = self.body(bare(name))
        found = []
        for contact in self.data.contact[: self.data.ncon]:
            bodies = [self.model.geom_bodyid[geom] for geom in contact.geom]
            if own not in bodies or contact.dist > TOUCH or self.body("hand") in bodies:
                continue
            other = bodies[1] if bodies[0] == own else bodies[0]
            normal = contact.frame[:3] if bodies[0] == own else -contact.frame[:3]
            name_of = self.scene.floor if other == 0 else self.entity_of.get(other)
            found.append((name_of, normal))
        return found

    def supports(self, name):
        """The places that an item touches: those under it, and upright planes beside it."""
        found = []
        for other, normal in self.contacts(name):
            place = self.scene.places.get(other)
            if place is not None and (normal[2] < -0.5 or place.upright and abs(normal[2]) < 0.5):
                found.append(other)
        return found

    def contains(self, name, place):
        """True if the middle of an item is within the walls of a place."""
        low, high = self.interior(place)
        item_low, item_high = self.extents(name)
        middle = (item_low + item_high) / 2
        return bool(np.all(middle > low) and np.all(middle < high))

    def statements(self, name):
        """The statements about an object, measured."""
        if name in self.scene.handles:
            fraction = self.fraction(name)
            state = ["closed()"] if fraction < CLOSED else ["open()"] if fraction > OPEN else []
            return state + (["inside_hand()"] if self.holds(name) else [])
        found = []
        supports = self.supports(name)
        for other in sorted(set(supports)):
            place = self.scene.places[other]
            if place.container:
                found += [f"inside_something({other})"] if self.contains(name, place) else []
            else:
                found.append(f"on_something({other})")
        for word, other in statements(self.scene.environment, name):
            if word == "next_to" and self.beside(name, other):
                found.append(f"next_to({other})")
        return found + (["inside_hand()"] if self.holds(name) else [])

    def beside(self, name, other):
        """True if two items are at most 30 cm apart."""
        if name not in self.scene.items or other not in self.scene.items:
            return False
        return float(np.linalg.norm(self.position(bare(name))[:2] - self.position(bare(other))[:2])) < 0.3

    def hand_is_at(self):
        """The entities at which the hand is: those within its reach, and the place under or behind it."""
        hand = self.hand()
        found = [name for name in self.scene.items | self.scene.handles
                 if float(np.linalg.norm(self.grip_point(name) - hand)) < REACH or self.holds(name)]
        exclude = self.body("hand")
        for direction, limit in (((0, 0, -1), 2.0), ((0, 1, 0), 0.2)):
            place = self.first_place(hand, np.array(direction, float), limit, exclude)
            found += [place] if place is not None and place not in found else []
        return sorted(found)

    def first_place(self, start, direction, limit, exclude):
        """The first piece of furniture in a direction, through items."""
        geom = np.zeros(1, np.int32)
        travelled, point = 0.0, start.copy()
        for _ in range(16):
            distance = mujoco.mj_ray(self.model, self.data, point, direction, None, 1, exclude, geom)
            if geom[0] < 0 or travelled + distance > limit:
                return None
            body = self.model.geom_bodyid[geom[0]]
            name = self.scene.floor if body == 0 else self.entity_of.get(body)
            if name in self.scene.places and name not in self.scene.items:
                place = self.scene.places[name]
                return name if place.upright or direction[2] < 0 else None
            point, travelled = point + direction * (distance + 1e-4), travelled + distance + 1e-4
        return None


def home():
    """The place of the hand before the first step."""
    return np.array([0.0, CORRIDOR, 0.8])
