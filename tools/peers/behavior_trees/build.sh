#!/usr/bin/env bash
# Builds BehaviorTree.CPP and the runner of this folder once, into the cache, and prints the path of the runner. The source comes
# with the Python package behaviortreepy (MIT, as BehaviorTree.CPP is).
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
. "$here/../../../scripts/system-packages.sh"
version=0.1.4
place="${XDG_CACHE_HOME:-$HOME/.cache}/longstep/peers/behavior-trees-$version"
runner="$place/runner-$(sha256sum "$here/runner.cpp" "$here/build.sh" | sha256sum | cut -c1-12)"
if [ -x "$runner" ]; then
    echo "$runner"
    exit
fi
command -v g++ >/dev/null || fail "there is no g++" "install a C++ compiler"
mkdir -p "$place"
exec 9>"$place/lock"
flock 9

source="$place/source/BehaviorTree.CPP"
if [ ! -d "$source" ]; then
    echo "fetching BehaviorTree.CPP" >&2
    work=$(mktemp -d "$place/fetch.XXXXXX")
    trap 'rm -rf "$work"' EXIT
    python3 -m pip download -q --no-deps --no-binary behaviortreepy -d "$work" "behaviortreepy==$version" >&2 ||
        fail "behaviortreepy $version cannot be fetched" "check the network, then run this again"
    mkdir "$work/source"
    tar -xzf "$work"/behaviortreepy-*.tar.gz -C "$work/source" --strip-components 1
    mv "$work/source" "$place/source"
fi

includes=(-I"$source/include")
for part in . lexy/include tinyxml2 minitrace minicoro flatbuffers cppzmq; do
    includes+=(-I"$source/3rdparty/$part")
done
flags=(-std=c++17 -O0 -w "${includes[@]}" -DLEXY_HAS_UNICODE_DATABASE=1 -DBTCPP_LIBRARY_VERSION='"4.8.2"')
library="$place/libbehaviortree.a"
if [ ! -f "$library" ]; then
    echo "building BehaviorTree.CPP" >&2
    objects=$(mktemp -d "$place/objects.XXXXXX")
    trap 'rm -rf "$objects"' EXIT
    files=()
    for file in "$source"/src/*.cpp "$source"/src/{actions,controls,decorators}/*.cpp "$source"/src/loggers/bt_{cout_logger,observer}.cpp \
        "$source"/3rdparty/tinyxml2/tinyxml2.cpp; do
        case $file in *WIN.cpp | *example.cpp) ;; *) files+=("$file") ;; esac
    done
    compile='objects=$1 file=$2; shift 2; exec g++ "$@" -c "$file" -o "$objects/$(basename "$file" .cpp).o"'
    printf '%s\0' "${files[@]}" | xargs -0 -P 2 -I{} sh -c "$compile" - "$objects" {} "${flags[@]}" >&2 ||
        fail "BehaviorTree.CPP cannot be built" "see the messages of the compiler"
    ar rcs "$library.new" "$objects"/*.o
    mv "$library.new" "$library"
fi
g++ "${flags[@]}" "$here/runner.cpp" "$library" -lpthread -ldl -o "$runner.new" >&2
mv "$runner.new" "$runner"
echo "$runner"
