#!/usr/bin/env bash
# Trains the adapters of the default model, one after the other: lab/adapter/all.sh PYTHON FOLDER [cuda]
# On two cores the first one takes a night; on a graphics card of 2023, seven minutes.
set -euo pipefail
cd "$(dirname "$0")/../.."

python=$1
out=$2
device=${3:-cpu}
mkdir -p "$out"
export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$PWD/target}
"$python" lab/adapter/test_train.py
cargo test --locked --quiet --manifest-path lab/programs/Cargo.toml
cargo build --release --locked --quiet --manifest-path lab/programs/Cargo.toml --bin training_data
cargo build --release --locked --quiet -p longstep-cli
target=$CARGO_TARGET_DIR/release
model=$("$target/longstep" model path qwen2.5-coder-1.5b)

# data NAME SUITE|TEXT...: writes the training data of suites or texts.
data() {
    local name=$1
    shift
    "$target/training_data" "$@" >"$out/$name.jsonl"
}

# The robots of `pool` and `avstore` are for choosing, and those of `test` are measured.
robots=()
for robot in lab/understanding/training/*; do
    case $robot in */pool | */avstore) ;; *) robots+=("$robot") ;; esac
done
data goals "${robots[@]}"
data choice lab/understanding/training/{pool,avstore}
data test lab/understanding/test/*
"$python" lab/adapter/synthetic.py "$out/goals.jsonl" "$out/synthetic.jsonl"
# What people wrote is seen three times, what a program made once.
"$python" lab/adapter/train.py "$out/goals.jsonl" "$model" "$out/goals.gguf" --epochs 3 --once "$out/synthetic.jsonl" \
    --device "$device" --minutes 1200 --rank 16 --rate 2.5e-4 --pack 12 --scenes "$([ "$device" = cpu ] && echo 1 || echo 4)" \
    --examples any --mixed 0.15 --measure "$out/choice.jsonl" --measure "$out/test.jsonl"

texts=lab/adapter
data description "$texts"/descriptions/*.txt
"$python" lab/adapter/train.py "$out/description.jsonl" "$model" "$out/description.gguf" \
    --device "$device" --task description --pack 8 --examples 2 --minutes 33 --rate 4e-4

data changes "$texts"/changes/*.txt
data compositions "$texts"/compositions/*.txt
"$python" lab/adapter/train.py "$out"/{changes,compositions}.jsonl "$model" "$out/plans.gguf" \
    --device "$device" --task plans --pack 10 --minutes 34 --rate 4e-4
