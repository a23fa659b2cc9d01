#!/usr/bin/env bash
# Tests the client for servers against a real one: llama-cpp-python's, which speaks OpenAI's dialect, with the 0.5B
# model of the catalogue (or the .gguf file that is given). The server is built the first time, which takes a quarter
# of an hour on two cores, and kept.
#
#     scripts/real-server.sh [MODEL.gguf]
set -euo pipefail
cd "$(dirname "$0")/.."

VERSION=0.3.36
PLACE="${XDG_CACHE_HOME:-$HOME/.cache}/longstep-build/llama-server"

if [ -n "${1:-}" ]; then
    model=$1
else
    cargo build --locked --quiet -p longstep-cli
    model=$("${CARGO_TARGET_DIR:-target}/debug/longstep" model pull qwen2.5-coder-0.5b)
fi

[ -x "$PLACE/bin/python" ] || python3 -m venv "$PLACE"
if ! "$PLACE/bin/pip" show llama-cpp-python 2>/dev/null | grep -qx "Version: $VERSION"; then
    # For any processor: a build for this one may use matrix units that a virtual machine announces and does not have.
    CMAKE_ARGS="-DGGML_NATIVE=OFF -DLLAVA_BUILD=OFF" \
        nice "$PLACE/bin/pip" install --quiet --no-cache-dir "llama-cpp-python[server]==$VERSION"
fi

# Compiled before the server runs: it would have to share the processor.
cargo test --locked --quiet -p longstep-llm --test real_server --no-run

port=$("$PLACE/bin/python" -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])')
log=$(mktemp)
"$PLACE/bin/python" -m llama_cpp.server --model "$model" --model_alias small --host 127.0.0.1 --port "$port" \
    --n_ctx 4096 --api_key a-key-for-this-test >"$log" 2>&1 &
server=$!
trap 'kill "$server" 2>/dev/null || true; wait "$server" 2>/dev/null || true; rm -f "$log"' EXIT

url="http://127.0.0.1:$port/v1"
for _ in $(seq 120); do
    if curl --silent --fail --output /dev/null -H "Authorization: Bearer a-key-for-this-test" "$url/models"; then
        ready=1
        break
    fi
    if ! kill -0 "$server" 2>/dev/null; then
        break
    fi
    sleep 0.5
done
if [ -z "${ready:-}" ]; then
    echo "the server did not start:" >&2
    tail -20 "$log" >&2
    exit 1
fi

LONGSTEP_TEST_SERVER="$url#small" LONGSTEP_API_KEY=a-key-for-this-test \
    cargo test --locked --quiet -p longstep-llm --test real_server -- --ignored --nocapture --test-threads=1
