#!/bin/bash
# SPDX-License-Identifier: MIT
# Prints what whole images of one encoder take, C library and libgcc included, start-up code, vectors and
# stack not: sections in bytes, and the ten largest functions and tables of those without handle or control
# plane.
# usage: size.sh TREE                    a cross tree, e.g. build/size
#        size.sh --figures TREE [KIND]   `FIGURE BYTES` a line: flash of all, RAM of those; of the programs
#                                        KIND-NAME: image, or static, which are linked with libdrehgeber.a
set -eu
figures=no
if [ "${1-}" = --figures ]; then
    figures=yes
    shift
fi
tree=${1:?usage: size.sh [--figures] TREE [KIND]}
nm=$(sed -n 's/^CMAKE_NM:[A-Z]*=//p' "$tree/CMakeCache.txt")
size=${nm%nm}size

# sections IMAGE: text, rodata, data, bss
sections() {
    "$size" -A "$1" | awk '{ bytes[$1] = $2 } END { print bytes[".text"] + 0, bytes[".rodata"] + 0, bytes[".data"] + 0, bytes[".bss"] + 0 }'
}

kind=${2-image}
images=("$tree/tests/bench/size/$kind"-*)
[ -e "${images[0]}" ] || { echo "size.sh: no programs $kind-* in $tree" >&2; exit 1; }
[ "$figures" = yes ] || printf '%-24s %8s %8s %8s %8s\n' "$(basename "$tree")" text rodata data bss
for image in "${images[@]}"; do
    name=${image##*/"$kind"-}
    read -r text rodata data bss <<<"$(sections "$image")"
    if [ "$figures" = no ]; then
        printf '%-24s %8s %8s %8s %8s\n' "$name" "$text" "$rodata" "$data" "$bss"
        continue
    fi
    echo "$name.flash $((text + rodata + data))"
    case $name in
    *-handle | *-control) ;;
    *) echo "$name.ram $((data + bss))" ;;
    esac
done
[ "$figures" = no ] || exit 0
for image in "${images[@]}"; do
    case $image in
    *-handle | *-control) ;;
    *)
        echo "largest of ${image##*/image-}:"
        "$nm" -t d -S --size-sort -r "$image" |
            awk '$3 !~ /[bB]/ && n++ < 10 { printf "    %6d %s\n", $2, $4 }'
        ;;
    esac
done
