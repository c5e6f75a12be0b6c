#!/bin/bash
# SPDX-License-Identifier: MIT
# Prints how fast the S36 with RS485 is, one figure a line. Nothing is asserted.
# usage: run.sh [BENCH_HF], by default the one of build/release
set -eu
cd "$(dirname "$0")/../.."
bench=${1:-build/release/tests/bench_hf}
if [ $# -eq 0 ]; then
    mkdir -p build/log
    [ -e build/release/build.ninja ] || cmake --preset release >build/log/release.configure
    cmake --build build/release --target bench_hf >build/log/bench.build
fi

# Instructions of a run with $1 requests 42h
instructions() {
    valgrind --tool=callgrind --callgrind-out-file=/dev/null "$bench" --callgrind "$1" 2>&1 |
        awk '/Collected :/ { print $4 }'
}

"$bench"
none=$(instructions 0)
many=$(instructions 1000)
printf '%-32s %10d\n' "instructions per 42h (aim: 1500)" $(((many - none) / 1000))
