#!/bin/bash
# SPDX-License-Identifier: MIT
# Compares figures with the limits beside it: fails when one is beyond its limit, or was not measured.
# usage: instructions.sh | limits.sh PREFIX; only the rows of limits that begin with PREFIX count
set -eu
exec awk -F '  +' -v prefix="$1" '
    NR == FNR { if ($0 !~ /^#/ && index($0, prefix) == 1) limit[substr($1, length(prefix) + 2)] = $2; next }
    { print }
    $1 in limit {
        seen[$1] = 1
        if ($2 + 0 > limit[$1] + 0) { print $1 ": " $2 " is beyond " limit[$1]; failed = 1 }
    }
    END {
        for (what in limit) if (!(what in seen)) { print what ": not measured"; failed = 1 }
        exit failed
    }' "$(dirname "$0")/limits" -
