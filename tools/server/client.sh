#!/usr/bin/env bash
# Generates a client from the OpenAPI description of a server, and makes twenty-odd calls with it:
# tools/server/client.sh PROGRAM, where PROGRAM is the example `demo_server`. The generator is installed once, into the cache.
set -euo pipefail
tools=$(cd "$(dirname "$0")" && pwd)
program=$1
shift
requirements="$tools/requirements.txt"
. "$tools/../../scripts/robots/venv.sh"
python=$(installed client)
PATH="$(dirname "$python"):$PATH" exec "$python" "$tools/client.py" --program "$program"
