"""A picture and the boxes of a scene, for `longstep see`: what a camera and a detector would give. See docs/guide/seeing.md."""

import argparse
import json
import os
import sys
import threading

os.environ.setdefault("MUJOCO_GL", "egl" if "--picture" in sys.argv else "disable")

import numpy as np

from hand import Hand
from scene import Scene, properties
from shapes import bare
from world import World

WIDTH, HEIGHT = 480, 360
# Half the edge of the box around a grip.
GRIP = 0.02


def corners(world, geom):
    """The lowest and the highest corner of a geom, in the world."""
    rotation, size = world.data.geom_xmat[geom].reshape(3, 3), world.model.geom_size[geom]
    reach = np.abs(rotation) @ size
    return world.data.geom_xpos[geom] - reach, world.data.geom_xpos[geom] + reach


def surface(world, name):
    """The board on which things stand: the parts of a piece of furniture that end at its surface."""
    place = world.scene.places[name]
    height = world.to_world(place, [0, 0, place.surface])[2]
    body = world.body(bare(name))
    first = world.model.body_geomadr[body]
    all = [corners(world, geom) for geom in range(first, first + world.model.body_geomnum[body])]
    boards = [(low, high) for low, high in all if abs(high[2] - height) < 0.001]
    return np.min([low for low, _ in boards], axis=0), np.max([high for _, high in boards], axis=0)


def extents(world, name):
    """The lowest and the highest corner of an entity."""
    scene = world.scene
    if name == scene.floor:
        return np.array([-3, -2, -0.1]), np.array([scene.width + 3, 1, 0])
    if name in scene.handles:
        grip = world.grip_point(name)
        return grip - GRIP, grip + GRIP
    place = scene.places.get(name)
    if name in scene.items or place is None or place.upright:
        return world.extents(name)
    if place.container:
        ends = [world.extents(name), world.interior(place)]
        return np.min([low for low, _ in ends], axis=0), np.max([high for _, high in ends], axis=0)
    return surface(world, name)


def boxes(world):
    """The scene file."""
    scene, found = world.scene, []
    owners = {handle: owner for owner, handle in scene.owned.items()}
    for kind, names in (("asset", scene.assets), ("object", scene.objects)):
        for name in names:
            low, high = extents(world, name)
            entry = {"name": name, "kind": kind, "position": rounded((low + high) / 2), "size": rounded(high - low)}
            place = scene.places.get(name)
            if place is not None and not place.container and name not in scene.items:
                entry["solid"] = True
            if name in owners:
                entry["part_of"] = owners[name]
            if name in scene.handles:
                entry["joint"] = {"position": round(float(world.data.qpos[world.joint(scene.handles[name])]), 4)}
            if properties(scene.environment, name):
                entry["properties"] = properties(scene.environment, name)
            found.append(entry)
    hand = {"name": "hand", "position": rounded(world.hand()), "closed": world.held is not None}
    return {"boxes": found, "hands": [hand]}


def rounded(point):
    return [round(float(part), 4) for part in point]


def picture(world, file):
    """Renders the scene from the front."""
    import mujoco
    from PIL import Image
    camera = mujoco.MjvCamera()
    camera.lookat[:] = [world.scene.width / 2, -0.15, 0.45]
    camera.distance = max(1.6, world.scene.width + 0.3)
    camera.azimuth, camera.elevation = 95, -22
    with mujoco.Renderer(world.model, HEIGHT, WIDTH) as renderer:
        renderer.update_scene(world.data, camera)
        Image.fromarray(renderer.render()).quantize(128).save(file, format="PNG", optimize=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--env", required=True, help="environment file")
    parser.add_argument("--boxes", metavar="FILE.json", help="write the boxes")
    parser.add_argument("--picture", metavar="FILE.png", help="write a picture")
    options = parser.parse_args()
    with open(options.env, encoding="utf-8") as file:
        environment = json.load(file)
    world = World(Scene(environment.get("environment", environment)))
    Hand(world, threading.Event()).settle()
    if options.boxes:
        with open(options.boxes, "w", encoding="utf-8") as file:
            lines = ",\n  ".join(json.dumps(entry) for entry in boxes(world)["boxes"])
            file.write('{"boxes": [\n  ' + lines + '],\n "hands": ' + json.dumps(boxes(world)["hands"]) + "}\n")
    if options.picture:
        picture(world, options.picture)


if __name__ == "__main__":
    main()
