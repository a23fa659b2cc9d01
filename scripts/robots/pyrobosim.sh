#!/usr/bin/env bash
# Installs what the pyrobosim robot needs (examples/robots/pyrobosim) into a virtual environment in the cache, and prints
# the path of its Python. `--installed` only looks, and fails if it is not installed.
set -euo pipefail
. "$(dirname "$0")/venv.sh"
installed pyrobosim
