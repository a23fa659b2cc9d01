#!/usr/bin/env bash
# Unpacks and tries what a folder of a release holds: try.sh [--any-library] FOLDER
#
# Checks the checksums; in each archive the files, the shared libraries that the program needs, and its answers; installs each
# wheel where no compiler is, and runs it; compares the answers of the programs with each other. Programs for another
# processor run under qemu-user. `--any-library` leaves the check of shared libraries out, for a program of this machine.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
. "$root/scripts/release/common.sh"
any_library=false
if [ "$1" = --any-library ]; then
    any_library=true
    shift
fi
folder=$(realpath "$1")
# The newest glibc that a program may ask for; build.sh chooses it.
glibc=2.17
environments="$root/examples/environments" plans="$root/examples/plans"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
skipped=()

# Sets `runner` to what runs programs of a processor here; fails if nothing does.
find_runner() {
    local found
    runner=()
    [ "$1" != "$(uname -m)" ] || return 0
    [ "$1" = aarch64 ] || return 1
    found=$(command -v qemu-aarch64-static || command -v qemu-aarch64) || return 1
    aarch64_root=$("$root/scripts/release/aarch64-root.sh")
    runner=("$found" -L "$aarch64_root")
}

# The program asks for no shared library but those of glibc, and for no newer version of it.
check_libraries() {
    local program=$1 needed newest
    need readelf "install binutils"
    needed=$(readelf --dynamic --wide "$program" | sed -n 's/.*(NEEDED).*\[\(.*\)\]$/\1/p')
    if grep -qvE '^(lib(c|m|dl|rt|pthread)\.so\.[0-9]|ld-linux-.*)$' <<<"$needed"; then
        fail "$program needs: $needed" "only libraries of glibc are on every machine"
    fi
    newest=$(readelf --version-info --wide "$program" | grep -oE 'GLIBC_[0-9.]+' | sed 's/GLIBC_//' | sort -Vu | tail -1)
    [ "$(printf '%s\n' "$newest" "$glibc" | sort -V | tail -1)" = "$glibc" ] ||
        fail "$program needs glibc $newest" "the archives are for glibc $glibc and newer"
    echo "  needs glibc $newest: $(tr '\n' ' ' <<<"$needed")" >&2
}

# A goal is solved, the plan is verified, and a plan with two violations is refused and repaired.
check_answers() {
    local program=("$@") status=0
    [ "$("${program[@]}" --version)" = "longstep $(version)" ] || fail "the version is not $(version)" "build the release again"
    "${program[@]}" solve --goal "put(juice, shelf top)" --env "$environments/pantry.json" --save "$work/plan.json" >/dev/null 2>&1
    "${program[@]}" verify "$work/plan.json" --env "$environments/pantry.json" >/dev/null
    "${program[@]}" verify "$plans/warm_cupcake.json" --env "$environments/flat.json" --domain virtualhome >/dev/null || status=$?
    [ "$status" -eq 10 ] || fail "a plan with violations ends with $status" "10 is expected"
    "${program[@]}" repair "$plans/warm_cupcake.json" --env "$environments/flat.json" --domain virtualhome >/dev/null
}

try_archive() {
    local archive=$1 name target file program
    name=$(basename "$archive" .tar.gz)
    target=${name#"longstep-$(version)-"}
    printf '%s\n' "$(basename "$archive")" >&2
    tar --extract --gzip --file "$archive" --directory "$work"
    program="$work/$name/longstep"
    for file in README.md CHANGELOG.md LICENSE-APACHE LICENSE-MIT THIRD-PARTY; do
        [ -s "$work/$name/$file" ] || fail "$archive lacks $file" "look at scripts/release/pack.sh"
    done
    $any_library || check_libraries "$program"
    if find_runner "${target%%-*}"; then
        check_answers "${runner[@]}" "$program"
        programs+=("${runner[*]} $program")
    else
        skipped+=("$(basename "$archive")")
    fi
}

# pip reads the tags of the wheel as it does on that machine; what it installs is run by that machine's Python.
try_wheel() {
    local wheel=$1 processor site python
    processor=$(sed -n 's/.*_\(x86_64\|aarch64\)\.whl$/\1/p' <<<"$wheel")
    printf '%s\n' "$(basename "$wheel")" >&2
    if ! find_runner "$processor"; then
        skipped+=("$(basename "$wheel")")
        return
    fi
    site="$work/site-$processor"
    python3 -m pip install --quiet --disable-pip-version-check --no-index --no-deps --target "$site" --python-version 3.10 \
        --implementation cp --abi abi3 --platform "manylinux2014_$processor" --only-binary=:all: "$wheel"
    python=(python3)
    [ ${#runner[@]} -eq 0 ] || python=("${runner[@]}" -E "PYTHONPATH=$site" "$aarch64_root/usr/bin/python3")
    (cd "$work" && PYTHONPATH="$site" "${python[@]}" "$root/crates/longstep-python/tests/installed.py" "$root") >&2
}

(cd "$folder" && sha256sum --quiet --check SHA256SUMS) || fail "a file of $folder is not the one of SHA256SUMS" "build the release again"
programs=()
for archive in "$folder"/*.tar.gz; do try_archive "$archive"; done
while read -r wheel; do try_wheel "$wheel"; done < <(compgen -G "$folder/*.whl")
for other in "${programs[@]:1}"; do
    step "the answers of $(basename "$(dirname "${other##* }")")"
    "$root/scripts/release/same_bytes.py" "${programs[0]}" "$other" --every "${LONGSTEP_EVERY:-1}" >&2
done
for name in ${skipped[@]+"${skipped[@]}"}; do
    printf 'not tried: %s (install qemu-user-static to run it here)\n' "$name" >&2
done
