"""A world of pyrobosim in the words of the domain beside it."""

import json
import os
import re

import numpy as np
from pyrobosim.core import WorldYamlLoader
from pyrobosim.core.hallway import Hallway
from pyrobosim.core.types import set_parent
from pyrobosim.planning.actions import ExecutionResult, ExecutionStatus, TaskAction
from pyrobosim.utils.general import get_data_folder
from pyrobosim.utils.pose import Pose
from shapely.geometry import Point

# The codes of steps that could not be done: pyrobosim's own statuses, all of them but success.
REFUSALS = {status: max(int(status), 0) or 100 for status in ExecutionStatus if status != ExecutionStatus.SUCCESS}


class World:
    """One robot in one world. Entities have the identifiers of an environment: `<banana_0>` is pyrobosim's `banana0`."""

    def __init__(self, options):
        # Without it, objects would begin at other places each time.
        np.random.seed(options.seed)
        path = options.world if os.path.exists(options.world) else os.path.join(get_data_folder(), options.world)
        self.world = WorldYamlLoader().from_file(path)
        self.robot, self.name = self.world.robots[0], self.world.name
        self.speed, self.state = options.speed, options.state
        self.performed = []
        self.rooms, self.hallways, self.objects = self.world.rooms, self.world.hallways, self.world.objects
        self.places = [place for location in self.world.locations for place in location.children]
        # A piece of furniture with one place is called by its own name.
        shown = {place: place.parent.name if len(place.parent.children) == 1 else place.name for place in self.places}
        shown |= {entity: entity.name for entity in [*self.rooms, *self.hallways, *self.objects]}
        self.names = {identifier(name): entity for entity, name in shown.items()}
        self.identifiers = {entity: name for name, entity in self.names.items()}
        if len(self.names) != len(shown):
            raise ValueError("two entities have the same name")
        self.actions = {"enter": "navigate", "approach": "navigate", "pick": "pick", "put-down": "place", "open": "open", "close": "close"}
        if self.state and os.path.exists(self.state):
            self.restore()

    def perform(self, action, arguments):
        """Performs one action and returns pyrobosim's result. pyrobosim itself checks what the action needs."""
        type = self.actions[action]
        entities = [self.names[name] for name in arguments]
        step = TaskAction(type)
        if type == "navigate":
            step.target_location = entities[0]
        elif type in ("pick", "place"):
            step.object = entities[0].name
        result = self.misplaced(type, entities) or self.robot.execute_action(step, realtime_factor=self.speed)
        if result.is_success():
            self.performed.append([action, *arguments])
        self.keep()
        return result

    def misplaced(self, type, entities):
        """Refuses what pyrobosim would do somewhere else: it opens, closes and puts down wherever the robot stands, and
        whatever it holds."""
        if type == "navigate":
            return None
        site = entities[-1]
        if self.robot.location is not site:
            here = getattr(self.robot.location, "name", "nowhere")
            return ExecutionResult(ExecutionStatus.PRECONDITION_FAILURE, f"Robot is at {here}, not at {site.name}.")
        held = self.robot.manipulated_object
        if type == "place" and held is not None and held is not entities[0]:
            return ExecutionResult(ExecutionStatus.PRECONDITION_FAILURE, f"Robot is holding {held.name}, not {entities[0].name}.")
        return None

    def cancel(self):
        """Ends the movement. The action that is under way returns as canceled."""
        if self.robot.executing_nav and self.robot.path_executor is not None:
            self.robot.path_executor.cancel_execution = True

    def statements(self, name):
        """Returns what is true of an entity."""
        entity = self.names[name]
        if entity in self.objects:
            if self.robot.manipulated_object is entity:
                return ["held()"]
            return [f"on({self.identifiers[entity.parent]})"]
        words = self.fixed(entity)
        if not getattr(entity, "is_open", True):
            words.append("closed()")
        if self.robot.location is entity:
            words.append("robot_at()")
        if entity is self.room():
            words.append("robot_in()")
        return words

    def fixed(self, entity):
        """Returns what is always true of a room, a place or a hallway."""
        if entity in self.hallways:
            return [f"joins({self.identifiers[room]})" for room in (entity.room_start, entity.room_end)]
        if entity in self.places:
            others = [f"shares({self.identifiers[other]})" for other in entity.parent.children if other is not entity]
            return [f"in_room({self.identifiers[entity.parent.parent]})", *others]
        return []

    def room(self):
        """Returns the room that the robot is in; at a hallway, the room at its near end."""
        location = self.robot.location
        if isinstance(location, Hallway):
            here = self.robot.get_pose()
            start, end = location.nav_poses[0], location.nav_poses[-1]
            is_start = here.get_linear_distance(start) <= here.get_linear_distance(end)
            return location.room_start if is_start else location.room_end
        if location in self.places:
            return location.parent.parent
        if location in self.rooms:
            return location
        # It was stopped on a wall between two rooms.
        pose = self.robot.get_pose()
        return min(self.rooms, key=lambda room: room.polygon.distance(Point(pose.x, pose.y)))

    def environment(self):
        """Returns the world as an environment file."""
        sites = [*self.rooms, *self.hallways, *self.places]
        kinds = {entity: kind for kind, entities in (("ROOM", self.rooms), ("HALLWAY", self.hallways), ("PLACE", self.places))
                 for entity in entities}
        properties = {}
        for entity in sites:
            owner = entity.parent if entity in self.places else entity
            properties[self.identifiers[entity]] = [kinds[entity], *(["LOCKED"] if getattr(owner, "is_locked", False) else [])]
        names = {self.identifiers[hall]: f"hallway between {hall.room_start.name} and {hall.room_end.name}" for hall in self.hallways}
        # `counter0_left` is the left counter.
        parts = [place for place in self.places if len(place.parent.children) > 1]
        names |= {self.identifiers[place]: f"{place.name.removeprefix(place.parent.name + '_')} {place.parent.category}" for place in parts}
        states = {kind: {self.identifiers[entity]: self.statements(self.identifiers[entity]) for entity in entities}
                  for kind, entities in (("asset", sites), ("object", self.objects))}
        return {
            "assets": [self.identifiers[entity] for entity in sites],
            "asset_states": {name: words for name, words in states["asset"].items() if words},
            "asset_properties": properties,
            "objects": [self.identifiers[entity] for entity in self.objects],
            "object_states": states["object"],
            "names": names,
        }

    def keep(self):
        """Writes the state of the world as a whole, so that a program that was killed continues in it."""
        if not self.state:
            return
        pose = self.robot.get_pose()
        held = self.robot.manipulated_object
        saved = {
            "robot": {"location": getattr(self.robot.location, "name", None), "pose": [pose.x, pose.y, pose.get_yaw()], "held": held and held.name},
            "objects": {item.name: [item.parent.name, item.pose.x, item.pose.y, item.pose.get_yaw()]
                        for item in self.objects if item is not held},
            "open": {site.name: site.is_open for site in [*self.hallways, *self.world.locations]},
            "performed": self.performed,
        }
        with open(self.state + ".new", "w", encoding="utf-8") as file:
            json.dump(saved, file)
        os.replace(self.state + ".new", self.state)

    def restore(self):
        with open(self.state, encoding="utf-8") as file:
            saved = json.load(file)
        find = self.world.get_entity_by_name
        for name, is_open in saved["open"].items():
            find(name).set_open(is_open, recursive=True)
        for name, (parent, x, y, yaw) in saved["objects"].items():
            item = find(name)
            set_parent(item, find(parent))
            item.set_pose(Pose(x=x, y=y, yaw=yaw))
            item.create_polygons()
        x, y, yaw = saved["robot"]["pose"]
        self.robot.set_pose(Pose(x=x, y=y, yaw=yaw))
        self.robot.location = saved["robot"]["location"] and find(saved["robot"]["location"])
        if saved["robot"]["held"]:
            self.robot._attach_object(find(saved["robot"]["held"]))
        self.world.update_polygons()
        self.performed = saved["performed"]


def identifier(name):
    """Returns the identifier of a name: `banana0` becomes `<banana_0>`, which people call a banana."""
    return "<" + re.sub(r"(?<=[a-z])(?=\d+$)", "_", name) + ">"
