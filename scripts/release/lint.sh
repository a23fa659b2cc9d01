#!/usr/bin/env bash
# Lints the scripts of a release with ShellCheck, and the Containerfile with hadolint.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
. "$root/scripts/release/common.sh"
tools=$(release_tools lint-requirements.txt)
cd "$root"
"$tools/shellcheck" --external-sources --source-path=scripts/release scripts/release.sh scripts/release/*.sh
"$tools/hadolint" --strict-labels Containerfile
