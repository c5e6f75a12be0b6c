#!/bin/bash
# SPDX-License-Identifier: MIT
# Prints how many instructions things take on this kind of machine, and bytes of RAM: `FIGURE NUMBER` a
# line. No clock is looked at: callgrind collects in bench_counted() alone, and writes down what it has
# whenever that returns. The C library's functions for memory are those that every x86-64 has.
# usage: instructions.sh BENCH...
set -eu
: "${1:?usage: instructions.sh BENCH...}"
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
export GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2,-AVX512F,-AVX512VL,-ERMS,-FSRM,-AVX_Fast_Unaligned_Load

# count BENCH: each of its lines, `FIGURE PARTS`, beside what was collected for it
count() {
    local out=$scratch/${1##*/} text parts figure number n=0
    text=$(valgrind --tool=callgrind "--callgrind-out-file=$out" --toggle-collect=bench_counted \
        --dump-after=bench_counted "$1" --count 2>"$out.log") || { cat "$out.log" >&2; exit 1; }
    while read -r figure parts number; do
        if [ "$parts" != bytes ]; then
            n=$((n + 1))
            number=$(awk -v parts="$parts" '/^totals:/ { printf parts == 1 ? "%d" : "%.1f", $2 / parts }' "$out.$n")
        fi
        echo "$figure $number"
    done <<<"$text"
}

for bench; do
    count "$bench"
done
