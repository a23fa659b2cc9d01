"""The actions of the household domain as movements of the hand. None of them looks at the plan or at its facts: an action
that physics does not allow fails with a reason."""

import math

import mujoco
import numpy as np

from scene import CORRIDOR
from world import CLOSED, OPEN, REACH, home

SPEED = 0.8
# The hand is stopped by something if it is this far behind its target, or pressed this deep into something.
BLOCKED, PRESSED = 0.05, 0.003
# An item is above its place by this much before it is put down.
HOVER = 0.06
# The height over what stands in front of a place that is reached from the front.
RAISE = 0.08
# The way after which a slip happens, so that it is in the air if the step is long enough.
SLIP = 0.25
# The distance that a tool rubs along a surface.
STROKE = 0.3


class Failure(Exception):
    """An action that could not be done, with the reason for people."""


class Stopped(Exception):
    """The robot was stopped."""


def is_taught(skills):
    """True if a displacement or a rotation was taught."""
    return "displacement" in skills or all(key in skills for key in ("axis", "centre", "radius", "angle"))


def shares(length):
    """The shares of a way of this length, a centimetre apart."""
    count = max(2, math.ceil(length / 0.01))
    return [part / count for part in range(1, count + 1)]


def rotated(axis, angle, vector):
    """A vector turned around an axis."""
    rotation, matrix = np.zeros(4), np.zeros(9)
    mujoco.mju_axisAngle2Quat(rotation, axis, angle)
    mujoco.mju_quat2Mat(matrix, rotation)
    return matrix.reshape(3, 3) @ vector


class Hand:
    """Moves the hand through a world."""

    def __init__(self, world, stopped):
        self.world, self.stopped = world, stopped
        self.target = home()
        world.data.mocap_pos[0] = self.target
        world.data.qpos[world.hand_joint():][:3] = self.target
        world.step(50)
        # The way back out of the place at which the hand is: points, the nearest last.
        self.way_back, self.is_above = [], False
        # The place from which a slip is counted; none if there is none to come.
        self.slip_from = None
        self.wiped, self.adjusted = set(), set()
        # The goal of the last movement; none before the first one.
        self.goal = None

    # --- movements ---

    def advance(self, count=5):
        """Simulates a few steps; everything that moves comes through here."""
        if self.stopped.is_set():
            raise Stopped()
        self.world.step(count)
        held = self.world.held
        if held is not None and self.slip_from is not None and self.moved() > SLIP:
            self.slip()
        elif held is not None and not self.world.holds(held):
            self.world.detach()
            self.settle()
            raise Failure(f"{held} was torn out of the hand")

    def moved(self):
        return float(np.linalg.norm(self.world.hand() - self.slip_from))

    def slip(self):
        """A fault on purpose: the fingers open. Nothing is told; what follows is measured."""
        self.slip_from = None
        self.world.detach()

    def settle(self):
        """Waits until nothing moves, at most three simulated seconds."""
        for _ in range(100):
            self.advance(15)
            if float(np.abs(self.world.data.qvel).max(initial=0)) < 0.01:
                return

    def go(self, point, speed=SPEED, what="the hand"):
        """Moves the target of the hand on a straight line. Something in the way stops it."""
        begin, end = self.target.copy(), np.array(point, float)
        count = max(1, math.ceil(float(np.linalg.norm(end - begin)) / speed / 0.01))
        for part in range(1, count + 1):
            self.target = begin + (end - begin) * part / count
            self.world.data.mocap_pos[0] = self.target
            self.advance()
            behind = float(np.linalg.norm(self.world.hand() - self.target))
            if behind > BLOCKED or self.world.pressed() > PRESSED:
                back = (begin - end) / max(1e-6, float(np.linalg.norm(end - begin)))
                self.target = self.world.hand() + back * min(0.02, float(np.linalg.norm(self.world.hand() - begin)))
                self.world.data.mocap_pos[0] = self.target
                self.advance(50)
                raise Failure(f"{what} is blocked {float(np.linalg.norm(end - self.target)) * 100:.0f} cm before its goal")
        self.advance(60)

    def leave(self):
        """Moves back out of the place at which the hand is, into the corridor. What hangs from the hand clears the rim of
        the place too."""
        held, hang = self.world.held, 0.0
        if self.is_above and held in self.world.scene.items:
            hang = float(self.world.hand()[2] - self.world.extents(held)[0][2])
        while self.way_back:
            self.go(self.way_back[-1] + np.array([0, 0, hang]), what=held or "the hand")
            self.way_back.pop()
        if self.target[1] > CORRIDOR + 0.01:
            self.go([self.target[0], CORRIDOR, self.target[2]])

    def enter(self, point, approach, height, what):
        """Moves from the corridor to a point: from above, from the front, or straight to it."""
        x, y, z = point
        above = {"straight": z, "front": z + RAISE, "top": max(z + HOVER, height)}[approach]
        outside = np.array([x, CORRIDOR, above])
        self.go([self.target[0], CORRIDOR, max(self.target[2], above)])
        self.go([x, CORRIDOR, max(self.target[2], above)])
        self.go(outside)
        self.way_back, self.is_above = [outside], approach == "top"
        if approach == "straight":
            self.go(point, what=what)
        else:
            over = np.array([x, y, above])
            self.go(over, what=what)
            self.way_back.append(over)
            self.go(point, speed=0.4, what=what)

    def approach_of(self, name):
        """The side from which an item or a handle is reached, and the height of what surrounds it."""
        if name in self.world.scene.handles:
            return "straight", 0
        best = ("top", 0)
        low, high = self.world.extents(name)
        middle = (low + high) / 2
        for other, place in self.world.scene.places.items():
            begin, end = self.world.interior(place)
            margin = np.array([0.06, 0.06, 0.1])
            if other != name and np.all(middle > begin - margin) and np.all(middle < end + margin):
                if place.approach == "front" and not place.upright:
                    return "front", 0
                best = ("top", max(best[1], end[2] if place.container else begin[2]))
        return best

    # --- actions ---

    def move_hand(self, name):
        """Moves the empty hand to an item, a handle or a place."""
        world = self.world
        self.leave()
        if name in world.scene.items or name in world.scene.handles:
            point = world.grip_point(name)
            approach, height = self.approach_of(name)
            self.enter(point, approach, height + HOVER, "the hand")
            distance = float(np.linalg.norm(world.grip_point(name) - world.hand()))
            if distance > REACH:
                raise Failure(f"{name} is {distance * 100:.0f} cm away from the hand")
        elif name in world.scene.places:
            self.over(name, None)
        else:
            raise Failure(f"there is no {name} in the scene")

    def over(self, name, item):
        """Moves to a place, with an item or without."""
        world, place = self.world, self.world.scene.places[name]
        if place.upright:
            low, high = world.interior(place)
            depth = 0.0 if item is None else world.extents(item)[1][1] - world.hand()[1]
            point = np.array([(low[0] + high[0]) / 2, high[1] - depth - 0.05, (low[2] + high[2]) / 2])
            self.enter(point, "straight", 0, item or "the hand")
            return
        spot = world.spot(item, name) if item else world.to_world(place, (np.array(place.low) + place.high) / 2)
        if spot is None:
            raise Failure(f"there is no room left on {name}")
        hang = world.hand()[2] - world.extents(item)[0][2] if item else 0.0
        surface = spot[2] if item else world.to_world(place, [0, 0, place.surface])[2]
        top = place.container and place.approach == "top"
        # Over a bin, above its rim: what is let go there falls in.
        rise = world.interior(place)[1][2] - surface + HOVER if top else HOVER / 2
        point = np.array([spot[0], spot[1], surface + hang + rise])
        self.enter(point, place.approach, 0, item or "the hand")

    def move_object(self, item, to):
        """Carries what is in the hand to a place or over an item."""
        self.need(item)
        if to in self.world.scene.places:
            self.leave()
            self.over(to, item)
        elif to in self.world.scene.items:
            self.leave()
            low, high = self.world.extents(to)
            hang = self.world.hand()[2] - self.world.extents(item)[0][2]
            approach, height = self.approach_of(to)
            self.enter([(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, high[2] + hang + HOVER], approach, height, item)
        else:
            raise Failure(f"{item} cannot be carried to {to}")
        self.need(item)

    def grasp(self, name):
        """Closes the hand around what is within reach."""
        if self.world.held is not None:
            raise Failure(f"the hand is closed around {self.world.held}")
        if name not in self.world.scene.items and name not in self.world.scene.handles:
            raise Failure(f"{name} cannot be grasped")
        distance = float(np.linalg.norm(self.world.grip_point(name) - self.world.hand()))
        if distance > REACH:
            raise Failure(f"{name} is {distance * 100:.0f} cm away from the hand")
        self.world.attach(name)
        self.advance(50)

    def release(self, name):
        """Opens the hand. What it held stays, or falls."""
        self.need(name)
        self.world.detach()
        self.settle()

    def pick_up(self, item, place):
        """Lifts what is in the hand until it touches nothing."""
        self.need(item)
        back = np.array([0, -1, 0]) if self.is_upright(place) else np.array([0, 0, 1])
        for _ in range(8):
            self.go(self.target + back * 0.01, speed=0.3, what=item)
            if not self.world.contacts(item):
                self.go(self.target + back * 0.02, speed=0.3, what=item)
                self.need(item)
                return
        raise Failure(f"{item} does not come off {place}")

    def put_down(self, item, place):
        """Lowers what is in the hand until it touches the place."""
        self.need(item)
        forward = np.array([0, 1, 0]) if self.is_upright(place) else np.array([0, 0, -1])
        for _ in range(120):
            touched = [other for other, _ in self.world.contacts(item)]
            if place in self.world.supports(item):
                self.advance(50)
                return
            if touched and touched[0] is not None and touched[0] != place:
                raise Failure(f"{item} touches {touched[0]} instead of {place}")
            self.go(self.target + forward * 0.004, speed=0.3, what=item)
            self.need(item)
        raise Failure(f"{item} does not reach {place}")

    def is_upright(self, name):
        place = self.world.scene.places.get(name)
        return place is not None and place.upright

    def need(self, name):
        """Fails if the hand does not hold something."""
        if not self.world.holds(name):
            raise Failure(f"{name} is not in the hand")

    def follow(self, name, skills, closes):
        """Moves a handle as it was taught: along the displacement, or around the axis. The joint of the scene is not used.
        What is to be closed is moved a little beyond the end, so that it meets its frame."""
        self.need(name)
        begin, start, beyond = self.world.fraction(name), self.world.hand(), 0.02 if closes else 0
        if "displacement" in skills:
            way = np.array(skills["displacement"], float)
            length = float(np.linalg.norm(way)) + beyond
            path = [start + way / np.linalg.norm(way) * length * share for share in shares(length)]
        else:
            axis, centre = (np.array(skills[key], float) for key in ("axis", "centre"))
            axis /= np.linalg.norm(axis)
            radial = start - centre - axis * float(axis @ (start - centre))
            off = abs(float(np.linalg.norm(radial)) - skills["radius"])
            if off > BLOCKED:
                raise Failure(f"{name} is {off * 100:.0f} cm away from the arc that was taught")
            angle = skills["angle"] + math.copysign(beyond / skills["radius"], skills["angle"])
            path = [start - radial + rotated(axis, angle * share, radial) for share in shares(abs(angle) * skills["radius"])]
        for point in path:
            self.go_through(point, name)
        self.advance(60)
        self.need(name)
        now = self.world.fraction(name)
        if closes and now > CLOSED or not closes and now < OPEN:
            raise Failure(f"{name} stopped at {now:.0%} of its way")
        if min(begin, now) > CLOSED and abs(now - begin) > 0.1:
            self.adjusted.add(name)
        self.way_back = []

    def turn(self, name, goal, speed=0.4):
        """Moves a handle along its joint until the door or drawer is open to a share of its range."""
        self.need(name)
        world, handle = self.world, self.world.scene.handles[name]
        begin = world.fraction(name)
        joint = mujoco.mj_name2id(world.model, mujoco.mjtObj.mjOBJ_JOINT, handle.joint)
        length = float(world.model.jnt_range[joint][1])
        axis, anchor = world.data.xaxis[joint].copy(), world.data.xanchor[joint].copy()
        start = world.hand() if handle.slides else world.hand() - anchor
        # A little beyond the end, so that a door that is to be closed meets its frame.
        ends = goal - 0.02 if goal <= 0 else goal
        count = max(2, math.ceil(abs(ends - begin) * length / 0.01))
        for part in range(1, count + 1):
            moved = (ends - begin) * length * part / count
            if handle.slides:
                point = start + axis * moved
            else:
                point = anchor + rotated(axis, moved, start)
            self.go_through(point, name)
        self.advance(60)
        self.need(name)
        now = world.fraction(name)
        if abs(now - max(goal, 0)) > 0.05:
            raise Failure(f"{name} stopped at {now:.0%} of its way")
        if min(begin, now) > CLOSED and abs(now - begin) > 0.1:
            self.adjusted.add(name)
        self.way_back = []

    def go_through(self, point, what):
        """Moves the target to a point on a path without stopping there."""
        self.target = np.array(point)
        self.world.data.mocap_pos[0] = self.target
        self.advance(8)
        if float(np.linalg.norm(self.world.hand() - self.target)) > BLOCKED:
            self.target = self.world.hand()
            self.world.data.mocap_pos[0] = self.target
            raise Failure(f"{what} is stuck")

    def open(self, name, share, skills):
        if self.world.fraction(name) > OPEN:
            raise Failure(f"{name} is open already")
        if is_taught(skills):
            return self.follow(name, skills, closes=False)
        handle = self.world.scene.handles[name]
        self.turn(name, share or (handle.wide if handle.slides else handle.narrow))

    def adjust(self, name, share, skills):
        now, handle = self.world.fraction(name), self.world.scene.handles[name]
        if now < CLOSED:
            raise Failure(f"{name} is closed")
        if is_taught(skills):
            return self.follow(name, skills, closes=False)
        # Without a share to aim at, wider where there is room for it.
        self.turn(name, share or (handle.wide if now < (handle.narrow + handle.wide) / 2 else handle.narrow))

    def close(self, name, skills):
        if self.world.fraction(name) < CLOSED:
            raise Failure(f"{name} is closed already")
        if is_taught(skills):
            return self.follow(name, skills, closes=True)
        self.turn(name, 0)

    def wipe(self, tool, place):
        """Rubs a held tool along a surface, and measures how far it rubbed."""
        self.need(tool)
        upright, travelled = self.is_upright(place), 0.0
        across = np.array([1, 0, 0])
        press = np.array([0, 0.003, 0]) if upright else np.array([0, 0, -0.003])
        middle = self.target.copy() + press
        for end in (0.08, -0.08, 0.08, 0):
            begin, goal = self.target.copy(), middle + across * end
            count = max(1, math.ceil(float(np.linalg.norm(goal - begin)) / 0.004))
            for part in range(1, count + 1):
                before = self.world.position(tool.strip("<>").lower())
                self.go_through(begin + (goal - begin) * part / count, tool)
                if place in self.world.supports(tool):
                    travelled += float(np.linalg.norm(self.world.position(tool.strip("<>").lower()) - before))
        self.need(tool)
        if travelled < STROKE:
            raise Failure(f"{tool} rubbed only {travelled * 100:.0f} cm along {place}")
        self.wiped.add((place, tool))

    def perform(self, order):
        """Performs the action of an order."""
        arguments, skills = order["arguments"], order.get("skills", {})
        share = skills.get("share")
        if share is not None and not (isinstance(share, (int, float)) and 0 < share <= 1):
            raise Failure("`share` is not a number from 0 to 1")
        actions = {
            "move-hand": self.move_hand, "move-object": self.move_object, "grasp": self.grasp, "release": self.release,
            "detach": self.pick_up, "attach": self.put_down, "wipe": self.wipe,
            "open-by-rotate": lambda name: self.open(name, share, skills),
            "open-by-slide": lambda name: self.open(name, share, skills),
            "adjust-by-rotate": lambda name: self.adjust(name, share, skills),
            "adjust-by-slide": lambda name: self.adjust(name, share, skills),
            "close-by-rotate": lambda name: self.close(name, skills), "close-by-slide": lambda name: self.close(name, skills),
        }
        if "-by-" in order["action"] and arguments[:1] != [] and arguments[0] not in self.world.scene.handles:
            raise Failure(f"{arguments[0]} is no handle")
        if len(arguments) != ACTIONS.get(order["action"]):
            raise Failure(f"this robot has no action {order['action']} with {len(arguments)} arguments")
        if order["action"] in ("move-hand", "move-object"):
            self.goal = arguments[-1]
        actions[order["action"]](*arguments)

    def is_at(self):
        """Where the hand is, measured. A hand over a can on a table is at both: the goal of its last movement counts, if the
        hand is there."""
        if self.goal is None:
            return []
        measured = self.world.hand_is_at()
        return [self.goal] if self.goal in measured else measured

    def has_lifted(self):
        """What the hand holds in the air, measured."""
        held = self.world.held
        in_the_air = held in self.world.scene.items and self.world.holds(held) and not self.world.contacts(held)
        return [held] if in_the_air else []


# The actions with the numbers of their arguments.
ACTIONS = {"move-hand": 1, "move-object": 2, "grasp": 1, "release": 1, "detach": 2, "attach": 2, "wipe": 2,
           "open-by-rotate": 1, "open-by-slide": 1, "adjust-by-rotate": 1, "adjust-by-slide": 1, "close-by-rotate": 1,
           "close-by-slide": 1}
