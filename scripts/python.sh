#!/usr/bin/env bash
# Builds the wheel of the Python package `longstep`, installs it into a clean environment, and checks it there:
#
#     scripts/python.sh [--program LONGSTEP] [--server DEMO_SERVER] [--profile NAME] [--every N]
#
# With the program, answers are compared with the bytes of its `--json` on all shipped suites (`--every 10`: a tenth of
# them). With the example `demo_server`, its client is tried. The tools are installed once, into the cache. The last line
# says which versions of Python the one wheel was tried with: those on the path, and those of pyenv.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
crate="$root/crates/longstep-python"
program='' server='' profile=release every=1
while [ $# -gt 0 ]; do
    case "$1" in
    --program) program=$(realpath "$2") ;;
    --server) server=$(realpath "$2") ;;
    --profile) profile=$2 ;;
    --every) every=$2 ;;
    *)
        printf 'error: unexpected argument %s\nhint: the beginning of %s lists the options\n' "$1" "$0" >&2
        exit 2
        ;;
    esac
    shift 2
done
set --
requirements="$root/scripts/python-requirements.txt"
. "$root/scripts/robots/venv.sh"
tools=$(dirname "$(installed python-package)")

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
step() { printf '\n== %s\n' "$*" >&2; }

export PYTHONDONTWRITEBYTECODE=1

step "the wheel"
wheels="${LONGSTEP_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/longstep}/python/$profile"
mkdir -p "$wheels"
rm -f "$wheels"/*.whl
"$tools/maturin" build --quiet --locked --profile "$profile" --manifest-path "$crate/Cargo.toml" --out "$wheels" >&2
wheel=$(ls "$wheels"/longstep-*-abi3-*.whl)
du -h "$wheel" >&2

# The interpreters: the newest of pyenv for each version, and those on the path. One wheel is for all of them.
pythons() {
    local version folder found
    for version in 3.10 3.11 3.12 3.13; do
        folder=$(find "${PYENV_ROOT:-$HOME/.pyenv}/versions" -maxdepth 1 -name "$version.*" 2>/dev/null | sort -V | tail -1)
        found="$folder/bin/python"
        [ -n "$folder" ] && [ -x "$found" ] || found=$(command -v "python$version" || true)
        # The shim of pyenv is there for versions that are not.
        if [ -n "$found" ] && "$found" -c 'import venv' 2>/dev/null; then echo "$version $found"; fi
    done
}

step "pip install without a network, and without a compiler on the path"
alone=()
if unshare --net true 2>/dev/null; then alone=(unshare --net); fi
mkdir "$work/empty"
tried=()
while read -r version python; do
    "$python" -m venv "$work/$version"
    PATH="$work/empty" ${alone[@]+"${alone[@]/#unshare/$(command -v unshare)}"} "$work/$version/bin/python" -m pip install --quiet \
        --disable-pip-version-check --no-index --no-deps "$wheel"
    (cd "$work" && "$work/$version/bin/python" "$crate/tests/installed.py" "$root")
    (cd "$crate/tests" && "$work/$version/bin/python" -m unittest --quiet test_arguments test_control test_docstrings test_plans \
        test_run test_session)
    tried+=("$version")
done < <(pythons)
[ ${#tried[@]} -gt 0 ] || {
    printf 'error: there is no Python from 3.10 on\n' >&2
    exit 1
}

step "the tests, in the environment of the tools"
# Nothing of an earlier installation is left.
"$tools/python" -m venv --system-site-packages "$work/checked"
"$work/checked/bin/python" - "$tools" <<'PY'
import pathlib, sys, sysconfig
# The packages of the tools are seen from here, and the wheel is not installed among them.
site = next(pathlib.Path(sys.argv[1]).parent.glob("lib/python*/site-packages"))
pathlib.Path(sysconfig.get_path("purelib"), "tools.pth").write_text(f"{site}\n")
PY
python="$work/checked/bin/python"
"$python" -m pip install --quiet --disable-pip-version-check --no-index --no-deps "$wheel"
export LONGSTEP_PROGRAM="$program" LONGSTEP_DEMO_SERVER="$server" LONGSTEP_EVERY="$every"
(cd "$crate/tests" && "$python" -W error::ResourceWarning -m unittest)

step "types"
export MYPY_CACHE_DIR="$work/mypy"
(cd "$work" && "$python" -m mypy --config-file "$crate/pyproject.toml" --package longstep)
(cd "$crate/tests" && "$python" -m mypy --config-file "$crate/pyproject.toml" ./*.py)
(cd "$root/examples/python" && for file in ./*.py; do "$python" -m mypy --strict "$file"; done)
(cd "$work" && "$python" -m mypy.stubtest longstep._longstep)

step "examples"
(cd "$root/examples/python" && for file in ./*.py; do "$python" "$file"; done) >"$work/examples.txt" || {
    cat "$work/examples.txt" >&2
    exit 1
}
"$python" "$crate/tests/notebook.py" "$root/examples/python/pantry.ipynb"

printf '\nThe package works with Python %s\n' "${tried[*]}"
[ -n "$program" ] || printf 'not compared with the program: pass --program PATH\n'
[ -n "$server" ] || printf 'not tried with a real server: pass --server PATH\n'
