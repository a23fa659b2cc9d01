#!/usr/bin/env bash
# Builds the program and the wheel for one target, and packs them: build.sh TARGET FOLDER
#
# Zig compiles the C and C++ and links, so the version of glibc is chosen here and not by the machine, the C++ library is
# inside the program, and no cross compiler is needed. Absolute paths are left out of the programs.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
. "$root/scripts/release/common.sh"
. "$root/scripts/system-packages.sh"
target=$1
folder=$(realpath "$2")
# The glibc of CentOS 7, Ubuntu 14.04 and Debian 8; the wheels are manylinux2014.
glibc=2.17

install_system_packages
if [ ! -d "$(rustc --print sysroot)/lib/rustlib/$target/lib" ]; then
    need rustup "install the standard library of Rust $(rustc -V | cut -d' ' -f2) for $target"
    rustup target add "$target" >&2 || fail "rustup could not add $target" "check the network, then run this again"
fi
tools=$(release_tools requirements.txt)
export PATH="$tools:$PATH"

# Where the sources and the results lie is no part of the program.
build=${CARGO_TARGET_DIR:-$root/target}
places=("${CARGO_HOME:-$HOME/.cargo}/registry/src=/registry" "$root=/longstep" "$build=/build")
maps="${places[*]/#/-ffile-prefix-map=}"
export CARGO_TARGET_DIR="$build" CARGO_INCREMENTAL=0 RUSTFLAGS="${places[*]/#/--remap-path-prefix=}" CFLAGS="$maps" CXXFLAGS="$maps"
case "$target" in
# As in a native build: ggml leaves these out when it cross-compiles, and with SOURCE_DATE_EPOCH. The engine needs them,
# and nothing else of the program does.
x86_64-*) export GGML_SSE42=ON GGML_AVX=ON GGML_AVX2=ON GGML_FMA=ON GGML_F16C=ON GGML_BMI2=ON ;;
esac

(cd "$root" && cargo zigbuild --release --locked -p longstep-cli --target "$target.$glibc")
"$root/scripts/release/pack.sh" "$build/$target/release/longstep" "$target" "$folder"

maturin build --release --locked --zig --target "$target" --compatibility manylinux2014 \
    --manifest-path "$root/crates/longstep-python/Cargo.toml" --out "$folder" >&2
