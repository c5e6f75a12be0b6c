#!/bin/bash
# SPDX-License-Identifier: MIT
# Prints what the core costs on a Cortex-M4 with -Os, in bytes.
set -eu
cd "$(dirname "$0")/../.."
mkdir -p build/log
[ -e build/size/build.ninja ] || cmake --preset size >build/log/size.configure
cmake --build build/size >build/log/size.build

row() { printf '%-22s %8s %8s %8s\n' "$@"; }
# text, data and bss of every object of the libraries, summed
total() { arm-none-eabi-size -t "$@" | awk '$NF == "(TOTALS)" { print $1, $2, $3 }'; }
ram=$(find build/size/tests -name 'ram.c*' -name '*.o*')
# ram DEVICE: bytes of its struct
ram() { echo $((16#$(arm-none-eabi-nm -S "$ram" | awk -v name="ram_$1" '$4 == name { print $2 }'))); }

row "Cortex-M4, -Os" text data bss
for library in build/size/libdg_*.a; do
    # shellcheck disable=SC2046 # three columns
    row "$(basename "$library" .a)" $(total "$library")
done
# Of these libraries, what an image has only when it calls it.
for object in canopen/co_eds canopen/slcan cia406/sheet; do
    # shellcheck disable=SC2046
    row "if called: $(basename "$object")" $(arm-none-eabi-size "build/size/libdg_$(dirname "$object").a" |
        awk -v name="$(basename "$object").c.obj" '$6 == name { print $1, $2, $3 }')
done
# What a program links that names one model, without and with a control plane; C library not included.
for image in build/size/tests/image-*; do
    # shellcheck disable=SC2046 # three columns
    row "$(basename "$image")" $(arm-none-eabi-size "$image" | awk 'NR == 2 { print $1, $2, $3 }')
done
for device in dg_hf dg_biss dg_cia406_device dg_ib; do
    echo "RAM of one device (sizeof(struct $device)): $(ram "$device")"
done
# Whole images of a CANopen node, C library included.
tests/bench/size/whole.sh | tests/bench/limits.sh whole.sh
