#!/usr/bin/env bash
# Generates a client from the OpenAPI description of a server, and makes twenty-odd calls with it:
# tools/server/client.sh PROGRAM, where PROGRAM is the example `demo_server`. The generator is installed once, into the cache.
set -euo pipefail
. "$(dirname "$0")/../../scripts/robots/venv.sh"
tools=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
cache="${LONGSTEP_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/longstep}/server"
# Other requirements and interpreters get an environment of their own.
mark=$(cat "$tools/requirements.txt" <(python3 --version) | sha256sum | cut -c1-12)
if [ ! -f "$cache/python-$mark/complete" ]; then
    install_into "$cache/python-$mark" "$cache/python.lock" "$tools/requirements.txt"
fi
PATH="$cache/python-$mark/bin:$PATH" exec "$cache/python-$mark/bin/python" "$tools/client.py" --program "$1"
