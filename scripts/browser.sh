#!/bin/sh
# Makes a browser and what drives it ready, once: prints the folder with node_modules.
# chromium and, if it is missing, node come from Debian, playwright-core and axe-core from npm. The folder is $LONGSTEP_BROWSER_CACHE, or
# longstep-browser in the cache of the user.
set -eu

folder=${LONGSTEP_BROWSER_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/longstep-browser}
playwright=1.54.1
axe=4.10.3

missing=
command -v chromium >/dev/null 2>&1 || missing="chromium"
command -v npm >/dev/null 2>&1 || missing="$missing nodejs npm"
if [ -n "$missing" ]; then
    echo "browser.sh: installing $missing" >&2
    # shellcheck disable=SC2086
    { apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $missing; } >&2
fi
mark="$folder/ready-$playwright-$axe"
if [ ! -e "$mark" ]; then
    mkdir -p "$folder"
    [ -e "$folder/package.json" ] || printf '{"private": true}\n' >"$folder/package.json"
    PLAYWRIGHT_SKIP_BROWSER_DOWNLOAD=1 npm install --silent --no-audit --no-fund --prefix "$folder" \
        "playwright-core@$playwright" "axe-core@$axe" >&2
    : >"$mark"
fi
printf '%s\n' "$folder"
