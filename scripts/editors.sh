#!/usr/bin/env bash
# Checks a new domain as an editor does: scripts/editors.sh LONGSTEP. Taplo, the language server behind TOML in editors, reads the
# schemas beside the files, finds nothing in them, and finds a misspelt key.
set -euo pipefail
here=$(cd "$(dirname "$0")/robots" && pwd)
program=$(realpath "$1")
requirements="$here/../editor-requirements.txt"
set --
. "$here/venv.sh"
taplo=$(dirname "$(installed editor)")/taplo

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"$program" domain new porter --starter >new.txt
mapfile -t files < <(find porter -name '*.toml' | sort)
"$taplo" lint "${files[@]}" 2>found.txt || {
    cat found.txt >&2
    exit 1
}
sed -i 's/^about = /abuot = /' porter/domain.toml
if "$taplo" lint porter/domain.toml 2>found.txt || ! grep --quiet "'abuot' was unexpected" found.txt; then
    printf 'error: a misspelt key was not found\n' >&2
    exit 1
fi
printf '%s files of a new domain are clean in Taplo, and a misspelt key is found\n' "${#files[@]}"
