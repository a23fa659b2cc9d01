#!/usr/bin/env bash
# Unpacks glibc and Python for aarch64 into the cache, from the packages of this Debian, and prints the folder: what a program
# needs to run under qemu-user (`qemu-aarch64-static -L FOLDER PROGRAM`). The packages of the system stay as they are. Prints
# $LONGSTEP_AARCH64_ROOT if it is set.
set -euo pipefail

fail() {
    printf 'error: %s\nhint: %s\n' "$1" "$2" >&2
    exit 1
}

if [ -n "${LONGSTEP_AARCH64_ROOT:-}" ]; then
    [ -e "$LONGSTEP_AARCH64_ROOT/lib/ld-linux-aarch64.so.1" ] || fail "$LONGSTEP_AARCH64_ROOT has no glibc for aarch64" "unset LONGSTEP_AARCH64_ROOT"
    echo "$LONGSTEP_AARCH64_ROOT"
    exit
fi
other="set LONGSTEP_AARCH64_ROOT to a folder with glibc and Python for aarch64"
[ "$(. /etc/os-release && echo "$ID")" = debian ] || fail "packages for aarch64 are taken from Debian, and this is another system" "$other"
cache="${LONGSTEP_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/longstep}/release"
folder="$cache/aarch64-root-$(. /etc/os-release && echo "$VERSION_ID")"
mkdir -p "$cache"
exec 9>"$folder.lock"
flock 9
if [ ! -e "$folder/complete" ]; then
    rm -rf "$folder"
    state="$folder/state"
    mkdir -p "$state"/{lists/partial,archives/partial}
    touch "$state/status"
    options=(-qq -o "Dir::State::Lists=$state/lists" -o "Dir::State::Status=$state/status" -o "Dir::Cache=$state"
        -o APT::Architecture=arm64 -o APT::Architectures=arm64)
    { apt-get "${options[@]}" update &&
        apt-get "${options[@]}" --yes --no-install-recommends --download-only install libc6 libgcc-s1 python3; } >&2 ||
        fail "apt-get could not fetch the packages for aarch64" "check the network, or $other"
    for package in "$state"/archives/*.deb; do dpkg-deb --extract "$package" "$folder"; done
    rm -rf "$state"
    touch "$folder/complete"
fi
echo "$folder"
