#!/usr/bin/env bash
# Builds the fuzz targets with the stable compiler and runs them: all of them, or those that are named.
#
#   scripts/fuzz.sh [--seconds N | --runs N] [--jobs N] [--build] [TARGET...]
#
# --seconds N  run each target for N seconds (default 60)
# --runs N     run each target N times instead, however long it takes
# --jobs N     run N targets at a time (default 2)
# --build      only build
#
# libFuzzer needs three things: its runtime (the crate libfuzzer-sys), coverage counters (compiler flags that the stable
# compiler takes), and no tool of its own. So nothing is installed. There is no address sanitizer: unsafe code is
# forbidden in this repository, and without it everything runs several times as fast.
#
# Exits with 1 when a target crashes, runs out of memory or needs more than 20 s for one input; says how to reproduce it.
# The build folder is $LONGSTEP_FUZZ_TARGET_DIR, else a folder of the cache outside the clone. Inputs that reach new code
# are kept in corpora/ there and used again.
set -euo pipefail
cd "$(dirname "$0")/.."

seconds=60 runs="" jobs=2 build_only="" targets=()
while [ $# -gt 0 ]; do
    case "$1" in
        --seconds) seconds=$2 && shift 2 ;;
        --runs) runs=$2 && shift 2 ;;
        --jobs) jobs=$2 && shift 2 ;;
        --build) build_only=yes && shift ;;
        -h | --help) sed -n '2,/^set/{/^set/d;s/^# \{0,1\}//;p}' "$0" && exit 0 ;;
        -*) echo "fuzz.sh: there is no option $1 (see --help)" >&2 && exit 2 ;;
        *) targets+=("$1") && shift ;;
    esac
done
known=()
for file in fuzz/fuzz_targets/*.rs; do
    known+=("$(basename "$file" .rs)")
done
[ ${#targets[@]} -gt 0 ] || targets=("${known[@]}")
for target in "${targets[@]}"; do
    if [ ! -f "fuzz/fuzz_targets/$target.rs" ]; then
        echo "fuzz.sh: there is no target $target; there are ${known[*]}" >&2
        exit 2
    fi
done

folder=${LONGSTEP_FUZZ_TARGET_DIR:-${XDG_CACHE_HOME:-$HOME/.cache}/longstep-build/fuzz}
triple=$(rustc -vV | sed -n 's/^host: //p')
# What cargo-fuzz passes, without the sanitizer: a counter for each edge, and the operands of comparisons.
flags="--cfg fuzzing -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4"
flags+=" -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table"
flags+=" -Cllvm-args=-sanitizer-coverage-trace-compares"
bins=()
for target in "${targets[@]}"; do
    bins+=(--bin "$target")
done
# With --target, build scripts and macros, which have no libFuzzer, are built without the flags.
RUSTFLAGS="$flags" cargo build --manifest-path fuzz/Cargo.toml --release --locked --quiet \
    --target "$triple" --target-dir "$folder" "${bins[@]}"
[ -z "$build_only" ] || exit 0

programs=$folder/$triple/release
artifacts=$folder/artifacts
logs=$folder/logs
mkdir -p "$artifacts" "$logs"
echo "inputs that crash are kept in $artifacts"
if [ -n "$runs" ]; then
    limit=(-runs="$runs")
else
    limit=(-max_total_time="$seconds")
fi

run_target() {
    local target=$1 corpus=$folder/corpora/$1 seeds=() dictionary=()
    mkdir -p "$corpus"
    for seed in "fuzz/seeds/$target"; do
        [ ! -d "$seed" ] || seeds+=("$seed")
    done
    [ ! -f "fuzz/$target.dict" ] || dictionary=(-dict="fuzz/$target.dict")
    "$programs/$target" "${limit[@]}" -max_len=4096 -rss_limit_mb=1024 -timeout=20 -print_final_stats=1 \
        -artifact_prefix="$artifacts/$target-" "${dictionary[@]}" "$corpus" "${seeds[@]}" >"$logs/$target" 2>&1
}

# Targets that run at the same time; `wait` for each of them tells how it ended.
failed=()
finish() {
    local target=$1 pid=$2 count
    if wait "$pid"; then
        count=$(sed -n 's/^stat::number_of_executed_units: *//p' "$logs/$target")
        echo "$target: ${count:-0} runs"
    else
        failed+=("$target")
        echo "$target: FAILED" >&2
        grep -aE "panicked at|^ERROR|SUMMARY|Test unit written to" -A 2 "$logs/$target" >&2 || tail -n 20 "$logs/$target" >&2
    fi
}
running_targets=() running_pids=()
for target in "${targets[@]}"; do
    run_target "$target" &
    running_targets+=("$target") running_pids+=("$!")
    if [ ${#running_pids[@]} -ge "$jobs" ]; then
        finish "${running_targets[0]}" "${running_pids[0]}"
        running_targets=("${running_targets[@]:1}") running_pids=("${running_pids[@]:1}")
    fi
done
for index in "${!running_pids[@]}"; do
    finish "${running_targets[$index]}" "${running_pids[$index]}"
done

if [ ${#failed[@]} -gt 0 ]; then
    {
        echo
        echo "failed: ${failed[*]}; the whole output is in $logs"
        for target in "${failed[@]}"; do
            find "$artifacts" -name "$target-*" -newer "$programs/$target" -printf "reproduce: $programs/$target %p\n"
        done
    } >&2
    exit 1
fi
