#!/usr/bin/env bash
# Installs behaviortreepy, the binding of BehaviorTree.CPP for Python, and mypy into a virtual environment in the cache, and prints
# the path of its Python.
set -euo pipefail
requirements="$(cd "$(dirname "$0")" && pwd)/python-requirements.txt"
. "$(dirname "$0")/../../../scripts/robots/venv.sh"
installed behavior-trees
