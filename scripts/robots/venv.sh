# Sourced by the scripts beside it: installs the Python packages of a robot into a virtual environment in the cache.
#
#     installed NAME [OPTION...]
#
# prints the path of its Python. The packages are those of examples/robots/NAME/requirements.txt, or of the file in
# $requirements if it is set; the options go to pip.
# With `--installed` as the script's own argument it only looks, and fails if they are not installed.

installed() {
    local name=$1 cache mark folder
    shift
    local requirements="${requirements:-$here/../../examples/robots/$name/requirements.txt}"
    cache="${LONGSTEP_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/longstep}/robots"
    # Other requirements get an environment of their own.
    mark=$(python3 -c 'import hashlib, sys; print(hashlib.sha256(open(sys.argv[1], "rb").read() + sys.version.encode()).hexdigest()[:12])' "$requirements")
    folder="$cache/$name-$mark"
    if [ ! -f "$folder/complete" ]; then
        if $only_look; then
            printf 'error: %s is not installed\nhint: run %s\n' "$name" "$0" >&2
            return 1
        fi
        install_into "$folder" "$cache/$name.lock" "$requirements" "$@" || return 1
    fi
    echo "$folder/bin/python"
}

# A virtual environment cannot be moved, so it is made in place; the file `complete` comes last.
install_into() {
    local folder=$1 lock=$2 requirements=$3
    shift 3
    mkdir -p "$(dirname "$folder")"
    exec 9>"$lock"
    flock 9
    [ ! -f "$folder/complete" ] || return 0
    rm -rf "$folder"
    echo "installing into $folder" >&2
    python3 -m venv "$folder" >&2
    if ! "$folder/bin/python" -m pip install --quiet --disable-pip-version-check "$@" --requirement "$requirements" >&2; then
        rm -rf "$folder"
        printf 'error: pip could not install %s\nhint: check the network, then run this again\n' "$requirements" >&2
        return 1
    fi
    touch "$folder/complete"
}

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
only_look=false
if [ "${1:-}" = "--installed" ]; then
    only_look=true
fi
