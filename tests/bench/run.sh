#!/bin/bash
# SPDX-License-Identifier: MIT
# Prints how fast the S36 with RS485 and the F36x8 are, one figure a line. Nothing is asserted.
# usage: run.sh [FOLDER], of bench_hf and bench_406; by default that of build/release
set -eu
cd "$(dirname "$0")/../.."
folder=${1:-build/release/tests}
if [ $# -eq 0 ]; then
    mkdir -p build/log
    [ -e build/release/build.ninja ] || cmake --preset release >build/log/release.configure
    cmake --build build/release --target bench_hf bench_406 >build/log/bench.build
fi

# Instructions of a run of bench $1 with $2 requests or samples
instructions() {
    valgrind --tool=callgrind --callgrind-out-file=/dev/null "$folder/$1" --callgrind "$2" 2>&1 |
        awk '/Collected :/ { print $4 }'
}

# Instructions of one of them; $1 bench, $2 what it is
one() {
    none=$(instructions "$1" 0)
    many=$(instructions "$1" 1000)
    printf '%-32s %10d\n' "$2" $(((many - none) / 1000))
}

"$folder/bench_hf"
one bench_hf "instructions per 42h (aim: 1500)"
"$folder/bench_406"
one bench_406 "instructions per 6004h (aim: 150)"
