#!/usr/bin/env bash
# Has Graphviz and Mermaid draw exported plans: tools/peers/diagrams.sh RUNNER [EVERY], where RUNNER is the program `diagrams`.
# Graphviz and the browser come from Debian, Mermaid from npm, once, into the folder of the browser.
set -euo pipefail
tools=$(cd "$(dirname "$0")" && pwd)
mermaid=12.3.0
folder=$("$tools/../../scripts/browser.sh")
if ! command -v dot >/dev/null; then
    { apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends graphviz; } >&2
fi
mark="$folder/ready-mermaid-$mermaid"
if [ ! -e "$mark" ]; then
    npm install --silent --no-audit --no-fund --prefix "$folder" "mermaid@$mermaid" >&2
    : >"$mark"
fi
plans=$(mktemp)
trap 'rm -f "$plans"' EXIT
"$1" "${2:-1}" >"$plans"
node "$tools/diagrams.mjs" "$folder" <"$plans"
