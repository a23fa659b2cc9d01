"""The HTTP interface of the Unity simulator of VirtualHome, answered by the simulator without graphics of its wheel.

    python3 server.py --environment kitchen.json

It listens on the loopback interface only, prints its address as its first line, and ends by itself. It has one character, no
animation, and draws a chart where Unity renders a picture. See docs/guide/virtualhome.md.
"""

import argparse
import base64
import json
import os
import signal
import struct
import sys
import time
import zlib
from http.server import BaseHTTPRequestHandler, HTTPServer

import graph
from scene import Refused, Scene

# Maximum length of a request; a graph of a whole flat has about 1 MB.
LARGEST = 16 << 20
# The time in which a client must send its request.
PATIENCE = 10
CAMERAS = ["PERSON_TOP", "PERSON_FRONT", "PERSON_LEFT", "PERSON_RIGHT", "PERSON_BACK", "PERSON_FROM_BACK"]


class Simulator:
    """Answers the requests that the Python client of the wheel sends."""

    def __init__(self, scene, options):
        self.scene, self.options = scene, options
        if options.state and os.path.exists(options.state):
            with open(options.state, encoding="utf-8") as file:
                scene.restore(json.load(file))

    def answer(self, request):
        action = request.get("action")
        handler = getattr(self, f"do_{action}", None) if isinstance(action, str) else None
        numbers, texts = request.get("intParams") or [], request.get("stringParams") or []
        answer = {"id": request.get("id"), "success": True, "message": "", "value": 0, "message_list": []}
        try:
            if handler is None:
                raise Refused(f"unknown action {action!r}")
            answer.update(handler(numbers, texts) or {})
        except (Refused, ValueError, KeyError, IndexError, TypeError, AttributeError) as error:
            reason = str(error) if isinstance(error, Refused) else f"the parameters of {action} are not right: {error}"
            answer.update(success=False, message=reason)
        return answer

    def keep(self):
        """Writes the scene as a whole, so that a server that was killed continues in it."""
        if self.options.state:
            with open(self.options.state + ".new", "w", encoding="utf-8") as file:
                json.dump(self.scene.saved(), file)
            os.replace(self.options.state + ".new", self.options.state)

    def do_idle(self, _numbers, _texts):
        pass

    def do_clear(self, _numbers, _texts):
        pass

    def do_environment(self, numbers, _texts):
        if numbers not in ([], [0]):
            raise Refused("this server has one scene, with the number 0")
        self.scene.reset()
        self.keep()

    do_fast_reset = do_reset = do_environment

    def do_environment_graph(self, _numbers, _texts):
        return {"message": json.dumps(self.scene.graph())}

    def do_add_character(self, _numbers, texts):
        wanted = json.loads(texts[0])
        self.scene.add_character(wanted["initial_room"] if wanted.get("mode") == "fix_room" else "")
        self.keep()

    def do_check_script(self, _numbers, texts):
        for line in texts:
            self.scene.perform(line, check_only=True)

    def do_render_script(self, _numbers, texts):
        config = json.loads(texts[0])
        for line in texts[1:]:
            self.perform(line, bool(config.get("skip_execution")))
        return {"message": json.dumps({"0": {"message": "Success"}})}

    def perform(self, line, check_only):
        time.sleep(self.options.pace / 2)
        try:
            self.scene.perform(line, check_only)
        except Refused as error:
            raise Refused(json.dumps({"0": {"message": str(error)}})) from error
        if not check_only:
            self.keep()
        time.sleep(self.options.pace / 2)

    def do_camera_count(self, _numbers, _texts):
        return {"value": len(CAMERAS) if self.scene.character is not None else 0}

    def do_character_cameras(self, _numbers, _texts):
        return {"message": json.dumps(CAMERAS)}

    def do_camera_image(self, numbers, texts):
        size = json.loads(texts[0])
        width, height = (max(1, min(int(size[name]), 4096)) for name in ("image_width", "image_height"))
        picture = base64.b64encode(chart(self.scene.graph(), width, height)).decode()
        return {"message_list": [picture for _ in numbers]}


def chart(scene, width, height):
    """Draws a PNG with one column for each thing that can be moved; the colour says where it is."""
    place = {edge["from_id"]: edge["to_id"] for edge in scene["edges"] if edge["relation_type"] in ("ON", "INSIDE", "HOLDS_RH")}
    things = [node["id"] for node in scene["nodes"] if "GRABBABLE" in node["properties"]] or [0]
    colour = {one: zlib.crc32(str(place.get(one)).encode()).to_bytes(4, "big")[:3] for one in things}
    row = b"\0" + b"".join(colour[things[x * len(things) // width]] for x in range(width))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(row * height)) + chunk(b"IEND", b"")


class Handler(BaseHTTPRequestHandler):
    timeout = PATIENCE

    def do_POST(self):
        length = int(self.headers.get("Content-Length") or 0)
        if not 0 < length <= LARGEST:
            self.send_error(413 if length > LARGEST else 411)
            return
        try:
            request = json.loads(self.rfile.read(length))
        except ValueError:
            request = None
        if not isinstance(request, dict):
            self.send_error(400, "a request is a JSON object")
            return
        body = json.dumps(self.server.simulator.answer(request)).encode()
        self.send_response(200)
        self.send_header("Content-Type", "application/json")
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, format, *arguments):
        pass


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("--environment", metavar="ENV.json", help="build the scene from an environment of the virtualhome domain")
    source.add_argument("--graph", metavar="GRAPH.json", help="use this scene graph")
    parser.add_argument("--port", type=int, default=8080, help="0 for any free one")
    parser.add_argument("--state", metavar="FILE", help="keep the scene and the lines performed in this file, and continue in it")
    parser.add_argument("--pace", type=float, default=0, metavar="SECONDS", help="the time that a line takes")
    parser.add_argument("--lifetime", type=float, default=3600, metavar="SECONDS", help="end after this time")
    options = parser.parse_args()
    with open(options.environment or options.graph, encoding="utf-8") as file:
        content = json.load(file)
    try:
        scene = Scene(graph.from_environment(content) if options.environment else content)
    except (ValueError, KeyError) as error:
        sys.exit(f"error: {options.environment or options.graph}: {error}")
    server = HTTPServer(("127.0.0.1", options.port), Handler)
    server.simulator = Simulator(scene, options)
    signal.signal(signal.SIGALRM, lambda *_: sys.exit(0))
    signal.setitimer(signal.ITIMER_REAL, options.lifetime)
    print(f"http://127.0.0.1:{server.server_port}", flush=True)
    try:
        server.serve_forever()
    except KeyboardInterrupt:
        pass


if __name__ == "__main__":
    main()
