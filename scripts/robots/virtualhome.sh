#!/usr/bin/env bash
# Installs what the VirtualHome server without graphics needs (examples/robots/virtualhome) into a virtual environment in
# the cache, and prints the path of its Python. `--installed` only looks, and fails if it is not installed.
set -euo pipefail
. "$(dirname "$0")/venv.sh"
# What the wheel asks for besides NumPy is for the films of the Unity simulator.
installed virtualhome --no-deps
