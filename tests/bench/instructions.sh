#!/bin/bash
# SPDX-License-Identifier: MIT
# Prints how many instructions the exchanges of a CANopen node (F3668) take on this kind of machine, without
# a clock: gcc -O2 and nothing else, callgrind, collection toggled on around one exchange.
# usage: instructions.sh [CC]
set -eu
cd "$(dirname "$0")/../.."
cc=${1:-gcc}
out=build/bench
mkdir -p "$out"
"$cc" -std=c11 -O2 -DNDEBUG -ffunction-sections -fdata-sections -Wl,--gc-sections '-DDG_VERSION=""' '-DDG_RELEASED=""' -Iinclude -Itests/support src/core/*.c \
    src/canopen/*.c src/cia406/*.c tests/support/ram_nvm.c tests/bench/bench_co.c -o "$out/bench_co"

# $1 exchange, $2 what it is
count() {
    local text
    text=$(valgrind --tool=callgrind --callgrind-out-file=/dev/null --toggle-collect=bench_exchange \
        "$out/bench_co" --exchange "$1" 2>&1) || { echo "$text" >&2; exit 1; }
    printf '%-40s %8s\n' "$2" "$(awk '/Collected :/ { print $4 }' <<<"$text")"
}

count sync "SYNC to TPDO, instructions"
count first "SDO upload of 1000h, instructions"
count middle "SDO upload of 1A03h:8, instructions"
count last "SDO upload of 650Eh, instructions"
count segmented "segmented upload of 21, instructions"
count block "block upload of 21, instructions"
printf '%-40s %8s\n' "CANopen node, bytes of RAM" "$("$out/bench_co" --bytes)"
