#!/bin/bash
# SPDX-License-Identifier: MIT
# Prints what a whole image of a CANopen node takes in flash, -Os, C library and libgcc included, start-up code
# not: text and data, one figure a line.
# usage: whole.sh [-v]; -v also prints the ten largest of each
set -eu
cd "$(dirname "$0")/../../.."
out=build/bench
mkdir -p "$out"

# $1 CPU, $2 device, $3 what it is
image() {
    local file=$out/node-$2-$1
    arm-none-eabi-gcc -std=c11 "-mcpu=$1" -mthumb -Os -DNDEBUG -ffreestanding -ffunction-sections \
        -fdata-sections '-DDG_VERSION=""' '-DDG_RELEASED=""' -Iinclude -Isrc/cia406 src/core/*.c src/motion/*.c \
        src/canopen/*.c src/cia406/*.c tests/bench/size/node/main.c "tests/bench/size/node/$2.c" -nostartfiles --specs=nano.specs \
        -Wl,-e,main -Wl,--gc-sections -o "$file"
    printf '%-40s %8s\n' "$3, bytes" "$(arm-none-eabi-size "$file" | awk 'NR == 2 { print $1 + $2 }')"
    [ "$verbose" = no ] || arm-none-eabi-nm -S --size-sort -r "$file" | awk '$3 != "b" && $3 != "B"' | head -10
}

verbose=no
[ "${1-}" != -v ] || verbose=yes
image cortex-m4 encoder "F3668, Cortex-M4"
image cortex-m0plus encoder "F3668, Cortex-M0+"
image cortex-m4 plain "stack and dictionary, Cortex-M4"
