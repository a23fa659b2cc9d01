"""The evolving-graph simulator of the `virtualhome` wheel, found without the rest of the wheel.

The wheel's packages import its Unity client and years-old libraries; only the folder of the simulator is put on the path.
"""

import importlib.util
import pathlib
import sys

_found = importlib.util.find_spec("virtualhome")
if _found is None or not _found.submodule_search_locations:
    sys.exit("error: the virtualhome wheel is not installed\nhint: run scripts/robots/virtualhome.sh, and use the Python that it prints")
sys.path.insert(0, str(pathlib.Path(_found.submodule_search_locations[0]) / "simulation"))

from evolving_graph.environment import EnvironmentGraph, EnvironmentState, Property, Relation  # noqa: E402
from evolving_graph.execution import ScriptExecutor  # noqa: E402
from evolving_graph.scripts import Action, Script, ScriptParseException, parse_script_line  # noqa: E402

__all__ = [
    "Action",
    "EnvironmentGraph",
    "EnvironmentState",
    "Property",
    "Relation",
    "Script",
    "ScriptExecutor",
    "ScriptParseException",
    "parse_script_line",
]
