#!/usr/bin/env bash
# Writes lab/results.md: every shipped suite with a model, the paper's scenarios where LONGSTEP_CORPUS names the folder of its
# recordings, and the totals of the test and the sealed suites for understanding. Runs are kept in eval/results and go on where they were
# cut off. The sealed suites count their runs (lab/understanding/README.md): do not run them to choose something.
#
#   LONGSTEP_CORPUS=../shared/corpus lab/results.sh [MODEL]
set -euo pipefail
cd "$(dirname "$0")/.."

model=${1:-qwen2.5-coder-1.5b}
runs=eval/results
target=${CARGO_TARGET_DIR:-target}
cargo build --release --locked --quiet -p longstep-cli
longstep=$target/release/longstep
"$longstep" model pull "$model" >/dev/null

page=$(mktemp)
trap 'rm -f "$page"' EXIT

say() { printf '%s\n' "$@" >>"$page"; }

# tables REPORT [all]: a report below a heading of ours. Incorrect attempts are listed for `all` only: the paper's
# instructions are not ours to print, and the held-out half is not to be looked at.
tables() {
    awk -v all="${2:-}" '
        /^# / { next }
        /^## / { skipped = (all == "" && $0 == "## Incorrect attempts"); sub(/^## /, "### ") }
        !skipped { print }' "$1" >>"$page"
}

# section TITLE FOLDER LISTED ARGUMENTS...: runs a suite and adds its tables.
section() {
    local title=$1 folder=$2 listed=$3
    shift 3
    echo "== $title" >&2
    "$longstep" eval "$@" --out "$runs/$folder" >/dev/null
    say "" "## $title" "" "    longstep eval $*" ""
    tables "$runs/$folder/report.md" "$listed"
}

# totals TITLE KIND SUITE...: a table with one row for each suite of lab/understanding/KIND.
totals() {
    local title=$1 kind=$2
    shift 2
    local folders=()
    echo "== $title" >&2
    for suite in "$@"; do
        local folder=$runs/$kind-${suite//\/suite/}
        "$longstep" eval "lab/understanding/$kind/$suite" --model "$model" --out "$folder" >/dev/null
        folders+=("$folder")
    done
    say "" "## $title" "" "    longstep eval lab/understanding/$kind/$1" "    lab/understanding/table.py eval/results/$kind-*" ""
    lab/understanding/table.py "${folders[@]}" >>"$page"
}

say "# Results" "" \
    "Written by \`lab/results.sh\`; what the measures mean is told in [evaluation.md](../docs/guide/evaluation.md)." "" \
    "- longstep $("$longstep" --version | cut -d' ' -f2), model \`$model\`" \
    "- $(uname -sm), $(grep -m1 'model name' /proc/cpuinfo | cut -d: -f2- | xargs), $(nproc) cores" \
    "- $(rustc --version)"

if [ -n "${LONGSTEP_CORPUS:-}" ]; then
    echo "== the paper's recorded replies" >&2
    "$longstep" eval paper --recorded --out "$runs/recorded" >/dev/null
    for table in trials feedback; do
        say "" "## The paper's recorded $table" "" "    longstep eval paper --recorded" ""
        tables "$runs/recorded/$table/report.md"
    done
    section "The fourteen scenarios, greedy" paper "" paper --model "$model"
    section "The fourteen scenarios, five seeds at temperature 0.7" paper-seeds "" paper --model "$model" --trials 5 --temperature 0.7
fi
section "Household: the paper's five scenes" household all household --model "$model"
section "Kitchen, development half" kitchen-development all kitchen --model "$model" --tag development
section "Kitchen, held-out half" kitchen-held-out "" kitchen --model "$model" --tag held-out
section "Branching" branching all branching --model "$model"
section "Two arms" two-arms all two-arms --model "$model"
section "Long chains" long all long --model "$model"
totals "Other robots: test" test care home laboratory warehouse workshop petshop
totals "Other robots: farm and hotel" sealed farm/suite-minimum hotel/suite-minimum farm/suite-full hotel/suite-full
totals "Other robots: sealed" sealed one two
mv "$page" lab/results.md
chmod 644 lab/results.md
trap - EXIT
