#!/usr/bin/env bash
# Installs what the MuJoCo robot needs (examples/robots/mujoco) into a virtual environment in the cache, and prints the
# path of its Python. `--installed` only looks, and fails if it is not installed.
set -euo pipefail
. "$(dirname "$0")/venv.sh"
installed mujoco
if ! $only_look && ! ldconfig -p 2>/dev/null | grep -qE 'libEGL\.so|libOSMesa\.so'; then
    echo "note: pictures need a GL without a screen (Debian: apt-get install libegl1 libgl1-mesa-dri)" >&2
fi
