"""Runs programs on the simulator without graphics as its own scripts do, without the HTTP interface.

    python3 reference.py --environment kitchen.json < PROGRAMS.json

reads a list of programs, each a list of lines (`[walk] <fridge> (306)`), and prints for each one {"executed": ..., "graph": ...}.
Each program begins in the scene as it was at first.
"""

import argparse
import json
import sys

import graph
from scene import Scene
from simulator import EnvironmentGraph, Script, ScriptExecutor, parse_script_line


def run(program, scene):
    scene.reset()
    scene.add_character("kitchen")
    executor = ScriptExecutor(EnvironmentGraph(scene.graph()), {}, 0)
    lines = [parse_script_line(line, number) for number, line in enumerate(program)]
    executed, state, _ = executor.execute(Script(lines), w_graph_list=False)
    scene.state = state
    return {"executed": executed, "graph": scene.graph(), "message": executor.info.get_error_string()}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--environment", required=True, metavar="ENV.json")
    options = parser.parse_args()
    with open(options.environment, encoding="utf-8") as file:
        scene = Scene(graph.from_environment(json.load(file)))
    json.dump([run(program, scene) for program in json.load(sys.stdin)], sys.stdout)


if __name__ == "__main__":
    main()
