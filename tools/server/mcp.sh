#!/usr/bin/env bash
# Installs the client of the Model Context Protocol (PyPI `mcp`) into a virtual environment in the cache, and prints the path
# of its Python.
set -euo pipefail
version=2.3.0
folder="${LONGSTEP_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/longstep}/peers/mcp-$version"
if [ ! -f "$folder/complete" ]; then
    mkdir -p "$(dirname "$folder")"
    exec 9>"$folder.lock"
    flock 9
    if [ ! -f "$folder/complete" ]; then
        rm -rf "$folder"
        python3 -m venv "$folder" >&2
        "$folder/bin/python" -m pip install --quiet --disable-pip-version-check "mcp==$version" >&2
        touch "$folder/complete"
    fi
fi
echo "$folder/bin/python"
