#!/bin/bash
# SPDX-License-Identifier: MIT
# Prints how fast the encoders are in virtual time, and what the running command costs (live.sh), one figure
# a line. Nothing is asserted but what limits says.
# usage: run.sh [TREE], a build tree; by default build/release, which is made if there is none
set -eu
cd "$(dirname "$0")/../.."
tree=${1:-build/release}
if [ $# -eq 0 ]; then
    mkdir -p build/log
    [ -e build/release/build.ninja ] || cmake --preset release >build/log/release.configure
    cmake --build build/release --target bench_hf bench_co bench_406 bench_biss bench_ib bench_roundtrip drehgeber \
        >build/log/bench.build
fi

# Instructions of a run of $1 with $2 operations
instructions() {
    valgrind --tool=callgrind --callgrind-out-file=/dev/null "$tree/tests/$1" --callgrind "$2" 2>&1 |
        awk '/Collected :/ { print $4 }'
}

# $1 bench, $2 what one operation is
each() {
    none=$(instructions "$1" 0)
    many=$(instructions "$1" 1000)
    printf '%-32s %10d\n' "instructions per $2" $(((many - none) / 1000))
}

"$tree/tests/bench_hf"
each bench_hf "42h (aim: 1500)"
"$tree/tests/bench_co"
tests/bench/instructions.sh | tests/bench/limits.sh instructions.sh
"$tree/tests/bench_406"
each bench_406 "6004h (aim: 150)"
"$tree/tests/bench_biss"
"$tree/tests/bench_ib"
tests/bench/live.sh "$tree"
