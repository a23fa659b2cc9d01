#!/usr/bin/env bash
# Packs a built program with its licences into an archive: pack.sh PROGRAM TARGET FOLDER
#
# Same program, same commit, same bytes: order, owners, modes and times of the files are fixed.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
. "$root/scripts/release/common.sh"
program=$1 target=$2 folder=$(realpath "$3")
name="longstep-$(version)-$target"
tar --version 2>/dev/null | grep -q GNU || fail "tar is not GNU tar" "install GNU tar; release archives need its --sort"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

mkdir "$work/$name"
cp "$program" "$work/$name/longstep"
cp "$root/README.md" "$root/CHANGELOG.md" "$root/LICENSE-APACHE" "$root/LICENSE-MIT" "$work/$name/"
"$root/scripts/release/third_party.py" longstep-cli "$target" >"$work/$name/THIRD-PARTY"
chmod 755 "$work/$name" "$work/$name/longstep"
chmod 644 "$work/$name"/[A-Z]*
tar --create --directory "$work" --sort=name --format=ustar --owner=0 --group=0 --numeric-owner --mtime="@$SOURCE_DATE_EPOCH" "$name" |
    gzip --no-name -9 >"$folder/$name.tar.gz"
du -h "$folder/$name.tar.gz" >&2
