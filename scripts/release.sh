#!/usr/bin/env bash
# Builds a release into dist/: archives of the program and wheels of the Python package, with their checksums. Then unpacks
# each and tries it; docs/guide/machines.md describes the result.
#
#     scripts/release.sh                        for both targets: an hour on two free cores
#     scripts/release.sh aarch64-unknown-linux-gnu          for one of them
#     scripts/release.sh --try                  tries what is in dist/ again
#     scripts/release.sh --rehearse PROGRAM     lints the scripts; packs a program that is built already, twice, and tries it
#
# The tools come from the Python package index, once, into the cache. Programs for another processor are tried under
# qemu-user, and the last lines say so if it is not installed. LONGSTEP_EVERY=20 compares the answers of the programs on every
# twentieth goal only.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
cd "$root"
parts="$root/scripts/release"
dist="$root/dist"
. "$parts/common.sh"

all_targets=(x86_64-unknown-linux-gnu aarch64-unknown-linux-gnu)

build_all() {
    local target
    # An archive of another version or commit is not left among the new ones.
    rm -rf "$dist"
    mkdir -p "$dist"
    for target in "$@"; do
        step "the program and the wheel for $target"
        "$parts/build.sh" "$target" "$dist"
    done
    step "checksums"
    write_checksums "$dist"
}

try_all() {
    step "what was built, unpacked and tried"
    "$parts/try.sh" "$dist"
}

# The same program, packed twice, has to give the same bytes, and a damaged archive has to be found.
rehearse() {
    local program target
    program=$(realpath "$1")
    target=$(rustc -vV | sed -n 's/^host: //p')
    work=$(mktemp -d) # for the trap, too
    trap 'rm -rf "$work"' EXIT
    step "lints of the scripts and of the Containerfile"
    "$parts/lint.sh"
    step "an archive, packed twice and tried"
    mkdir "$work/first" "$work/second"
    "$parts/pack.sh" "$program" "$target" "$work/first"
    "$parts/pack.sh" "$program" "$target" "$work/second"
    cmp "$work"/first/*.tar.gz "$work"/second/*.tar.gz || fail "the same program gives other archives" "look at scripts/release/pack.sh"
    write_checksums "$work/first"
    "$parts/try.sh" --any-library "$work/first"
    printf x >>"$(ls "$work"/first/*.tar.gz)"
    if "$parts/try.sh" --any-library "$work/first" >/dev/null 2>&1; then fail "a damaged archive passed" "look at scripts/release/try.sh"; fi
    step "the comparison of two programs"
    "$parts/same_bytes.py" --self-test "$program"
}

case "${1:-}" in
--try) try_all ;;
--rehearse)
    [ $# -eq 2 ] || fail "--rehearse needs a program" "scripts/release.sh --rehearse target/debug/longstep"
    rehearse "$2"
    ;;
-*) fail "unexpected argument $1" "the beginning of $0 lists the options" ;;
*)
    targets=("$@")
    [ $# -gt 0 ] || targets=("${all_targets[@]}")
    build_all "${targets[@]}"
    try_all
    ;;
esac
