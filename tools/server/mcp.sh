#!/usr/bin/env bash
# Installs the client of the Model Context Protocol (PyPI `mcp`) into a virtual environment in the cache, and prints the path
# of its Python.
set -euo pipefail
requirements="$(cd "$(dirname "$0")" && pwd)/mcp-requirements.txt"
. "$(dirname "$0")/../../scripts/robots/venv.sh"
installed mcp
