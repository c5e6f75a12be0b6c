#!/bin/bash
# SPDX-License-Identifier: MIT
# Prints what the running command costs, one process with 1, 10, ... encoders of a kind at rest: time until it
# is ready, memory (proportional and resident), processor and wake-ups a second with nobody connected, and
# round trips of one client, half of them and 99 of 100: over the wire to the first encoder, and of a SCPI
# query; the same in TREE/tests/bench/live.figures. Nothing is asserted but that it answers. SocketCAN is measured where vcan0 is:
# tools/rig/run tests/bench/live.sh TREE
# usage: live.sh TREE [COUNT...]    TREE a build tree with the target `benches`; default: 1 10 100
set -eu
tree=$(realpath "${1:?usage: live.sh TREE [COUNT...]}")
shift
[ $# -gt 0 ] || set -- 1 10 100
idle_s=${DREHGEBER_IDLE_S:-5}
kept=$tree/tests/bench/live.figures
folder=$(mktemp -d)
encoder=
# shellcheck disable=SC2317 # called by the trap
finish() {
    [ -z "$encoder" ] || kill "$encoder" 2>/dev/null || true
    rm -rf "$folder"
}
trap finish EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

# kind: model, wire, encoders a wire, the client of its wire
# 32 addresses, 127 node-IDs, 8 slaves, a wire of its own, a ring of 512
kinds="s3684-rs485 pty    32  pty
f3668       slcan  100 slcan
f3668       can    100 can
s3684-biss  sim    8   -
ssi-25      sim    1   -
ocd-ib-k3   modbus 512 modbus"

# rig MODEL WIRE PER_WIRE COUNT: a rig file; the first encoder is as delivered
rig() {
    awk -v model="$1" -v wire="$2" -v per="$3" -v count="$4" 'BEGIN {
        address["modbus"] = "127.0.0.1:0"; address["can"] = "vcan0"
        print "[rig]\nname = live"
        for (i = 0; i < count; i++) {
            at = i % per
            if (at == 0) {
                printf "[bus b%d]\nwire = %s\n", i / per, wire
                if (wire in address) print "address = " address[wire]
            }
            printf "[encoder e%d]\nmodel = %s\nbus = b%d\n", i, model, i / per
            if (model == "f3668") print "node = " (at == 0 ? 63 : at < 63 ? at : at + 1)
            if (wire == "pty") printf "address = 0x%X\npace = 0\n", 64 + at
        }
    }'
}

# start RIG: the command, ready; ready_ms is how long that took
start() {
    local begin
    : >"$folder/out"
    begin=$(date +%s%N)
    "$tree/drehgeber" run -q "$1" --control "unix:$folder/control" >"$folder/out" &
    encoder=$!
    until grep -q '^ready rig' "$folder/out"; do
        kill -0 "$encoder" || exit 1
        sleep 0.002
    done
    ready_ms=$((($(date +%s%N) - begin) / 1000000))
}

stop() {
    kill "$encoder"
    wait "$encoder"
    encoder=
}

# place WIRE: what a client opens for the first encoder
place() {
    local at
    at=$(sed -n '1s/^ready [^ ]* [a-z]*:\([^ ]*\).*/\1/p' "$folder/out")
    case $1 in
    modbus) at=${at##*:} && echo "${at%/*}" ;;
    slcan | can) echo "${at%/*}" ;;
    *) echo "$at" ;;
    esac
}

memory() {
    awk -v key="$1:" '$1 == key { print $2 }' "/proc/$encoder/smaps_rollup"
}

# Nanoseconds on a processor so far, and times it has waited for something, of all threads
spent() {
    cat "/proc/$encoder"/task/*/schedstat | awk '{ ns += $1 } END { printf "%.0f\n", ns }'
}
woken() {
    cat "/proc/$encoder"/task/*/status | awk '/^voluntary_ctxt_switches/ { n += $2 } END { print n }'
}

# measure MODEL WIRE PER_WIRE CLIENT COUNT: a row
measure() {
    local ns waits trip=- scpi
    rig "$1" "$2" "$3" "$5" >"$folder/live.ini"
    start "$folder/live.ini"
    ns=$(spent)
    waits=$(woken)
    sleep "$idle_s"
    ns=$(($(spent) - ns))
    waits=$(($(woken) - waits))
    [ "$4" = - ] || trip=$("$tree/tests/bench/roundtrip" "$4" "$(place "$4")")
    scpi=$("$tree/tests/bench/roundtrip" scpi "$folder/control")
    awk -v row="$1:$2 $5 $ready_ms $(memory Pss) $(memory Rss)" -v ns="$ns" -v waits="$waits" -v s="$idle_s" \
        -v trip="$trip" -v scpi="$scpi" 'BEGIN {
        split(row, a); split(trip " -", w); split(scpi, c)
        printf "%-18s %5d %6d %7d %7d %7.2f %7.1f %9s %8s %8s %8s\n", a[1], a[2], a[3], a[4], a[5],
            ns / s / 1e7, waits / s, w[1], w[2], c[1], c[2] }' | tee -a "$kept"
    stop
}

printf '%-18s %5s %6s %7s %7s %7s %7s %9s %8s %8s %8s\n' "encoders at rest" count ms "kB PSS" "kB RSS" "% CPU" wakes/s \
    "wire p50" "p99 us" "SCPI p50" "p99 us" | tee "$kept"
while read -r model wire per_wire client; do
    for count; do
        # There is one interface, if any.
        if [ "$wire" = can ] && { [ ! -e /sys/class/net/vcan0 ] || [ "$count" -gt "$per_wire" ]; }; then
            continue
        fi
        measure "$model" "$wire" "$per_wire" "$client" "$count"
    done
done <<<"$kinds"
