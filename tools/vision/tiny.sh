#!/usr/bin/env bash
# Writes the tiny vision models with random weights (tiny.py) into the cache, and prints their folder. For the tests of
# embedded vision.
set -euo pipefail
. "$(dirname "$0")/../../scripts/robots/venv.sh"
vision=$(cd "$(dirname "$0")" && pwd)
text="$vision/../../crates/longstep-model/domains/household/domain.toml"
cache="${LONGSTEP_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/longstep}/vision"
# Other scripts, texts and interpreters get folders of their own.
mark=$(cat "$vision/requirements.txt" <(python3 --version) | sha256sum | cut -c1-12)
python="$cache/python-$mark"
if [ ! -f "$python/complete" ]; then
    install_into "$python" "$cache/python.lock" "$vision/requirements.txt"
fi
folder="$cache/tiny-$(cat "$vision/tiny.py" "$text" | sha256sum | cut -c1-12)-$mark"
if [ ! -d "$folder" ]; then
    rm -rf "$folder.new"
    "$python/bin/python" "$vision/tiny.py" "$folder.new" --text "$text"
    mv "$folder.new" "$folder"
fi
echo "$folder"
