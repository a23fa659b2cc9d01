#!/usr/bin/env bash
# Installs what the MuJoCo robot needs (examples/robots/mujoco) into a virtual environment in the cache, and prints the
# path of its Python. `--installed` only looks, and fails if it is not installed.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
requirements="$here/../../examples/robots/mujoco/requirements.txt"
cache="${LONGSTEP_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/longstep}/robots"
# Other requirements get an environment of their own.
mark=$(python3 -c 'import hashlib, sys; print(hashlib.sha256(open(sys.argv[1], "rb").read() + sys.version.encode()).hexdigest()[:12])' "$requirements")
folder="$cache/mujoco-$mark"

if [ -x "$folder/bin/python" ]; then
    echo "$folder/bin/python"
    exit
fi
if [ "${1:-}" = "--installed" ]; then
    printf 'error: the MuJoCo robot is not installed\nhint: run scripts/robots/mujoco.sh\n' >&2
    exit 1
fi
# A virtual environment cannot be moved, so it is made in place, and its Python comes last.
mkdir -p "$cache"
exec 9>"$cache/mujoco.lock"
flock 9
if [ ! -x "$folder/bin/python" ]; then
    rm -rf "$folder"
    echo "installing MuJoCo into $folder" >&2
    python3 -m venv "$folder" >&2
    if ! "$folder/bin/python" -m pip install --quiet --disable-pip-version-check --requirement "$requirements" >&2; then
        rm -rf "$folder"
        printf 'error: pip could not install MuJoCo\nhint: check the network, then run this again\n' >&2
        exit 1
    fi
fi
if ! ldconfig -p 2>/dev/null | grep -qE 'libEGL\.so|libOSMesa\.so'; then
    echo "note: pictures need a GL without a screen (Debian: apt-get install libegl1 libgl1-mesa-dri)" >&2
fi
echo "$folder/bin/python"
