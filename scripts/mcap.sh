#!/usr/bin/env bash
# Installs the Python package `mcap`, with which recordings of runs are read back, into a virtual environment in the cache,
# and prints the path of its Python. `--installed` only looks, and fails if it is not installed.
set -euo pipefail
requirements="$(cd "$(dirname "$0")" && pwd)/mcap-requirements.txt"
. "$(dirname "$0")/robots/venv.sh"
installed mcap
