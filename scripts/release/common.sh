# Sourced by scripts/release.sh and the scripts beside this one, which set `root`: messages, the version, the time of a release.
# shellcheck shell=bash
# shellcheck disable=SC2154

fail() {
    printf 'error: %s\nhint: %s\n' "$1" "$2" >&2
    exit 1
}

step() { printf '\n== %s\n' "$*" >&2; }

need() { command -v "$1" >/dev/null || fail "$1 is not installed" "$2"; }

version() { sed -n '/^\[workspace.package\]/,/^\[/s/^version = "\(.*\)"$/\1/p' "$root/Cargo.toml"; }

# The time of the files in archives and wheels: that of the commit, unless it is set.
export SOURCE_DATE_EPOCH="${SOURCE_DATE_EPOCH:-$(git -C "$root" log -1 --format=%ct)}"

# Writes the checksums of the archives and wheels in a folder.
write_checksums() {
    (
        cd "$1" || exit
        shopt -s nullglob
        LC_ALL=C
        sha256sum -- *.tar.gz *.whl >SHA256SUMS
        cat SHA256SUMS >&2
    )
}

# Prints the folder of the tools in scripts/release/$1, installed into the cache.
release_tools() {
    local requirements="$root/scripts/release/$1"
    (
        set --
        . "$root/scripts/robots/venv.sh"
        dirname "$(installed "release-$(basename "$requirements" .txt)")"
    )
}
