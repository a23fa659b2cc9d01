#!/bin/sh
# Tests the page of the server in a browser: scripts/page.sh [FOLDER FOR SCREENSHOTS] [PART OF THE NAME OF A CASE]
set -eu

here=$(cd "$(dirname "$0")/.." && pwd)
folder=$("$here/scripts/browser.sh")
cd "$here"
# With the features of the tests, so that nothing is compiled twice.
cargo build --quiet --workspace --example demo_server
target=${CARGO_TARGET_DIR:-$here/target}
exec node crates/longstep-server/tests/page/page.mjs "$target/debug/examples/demo_server" "$folder" "${1:-}" "${2:-}"
