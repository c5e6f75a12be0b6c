#!/bin/bash
# SPDX-License-Identifier: MIT
# Prints what the running command costs, one figure a line: round trips of a client, memory, processor time
# at rest. Nothing is asserted. CAN is measured where vcan0 is: tools/rig/run tests/bench/live.sh TREE
# usage: live.sh TREE, a build tree
set -eu
cd "$(dirname "$0")/../.."
tree=${1:?usage: live.sh TREE}
idle_s=5
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

# start ARGUMENT...: a command that is ready, all of it
start() {
    : >"$folder/out"
    "$tree/drehgeber" run -q "$@" --control "unix:$folder/control" >"$folder/out" &
    encoder=$!
    for _ in $(seq 300); do
        ! grep -q '^control' "$folder/out" || return 0
        sleep 0.1
    done
    echo "live.sh: not ready: drehgeber run $*" >&2
    exit 1
}

stop() {
    kill "$encoder"
    wait "$encoder"
    encoder=
}

# Where the first encoder is, without the wire's name
place() {
    sed -n '1s/^ready [^ ]* [a-z]*://p' "$folder/out"
}

figure() {
    printf '%-32s %10s\n' "$1" "$2"
}

rss() {
    awk '/^VmRSS/ { print $2 }' "/proc/$encoder/status"
}

# Nanoseconds on a processor so far
spent() {
    cut -d ' ' -f 1 "/proc/$encoder/schedstat"
}

# Times it has waited for something so far
woken() {
    awk '/^voluntary_ctxt_switches/ { print $2 }' "/proc/$encoder/status"
}

# idle WHAT: of one processor, and wake-ups, with nobody connected
idle() {
    local before waits
    before=$(spent)
    waits=$(woken)
    sleep "$idle_s"
    figure "% CPU, $1" "$(awk -v ns=$(($(spent) - before)) -v s="$idle_s" 'BEGIN { printf "%.2f", ns / s / 1e7 }')"
    figure "wake-ups/s, $1" "$(((($(woken) - waits)) / idle_s))"
}

start f3668 --slcan
slcan=$(place)
"$tree/tests/bench/roundtrip" slcan "${slcan%/*}"
stop
if [ -e /sys/class/net/vcan0 ]; then
    start f3668 --can vcan0
    "$tree/tests/bench/roundtrip" can vcan0
    stop
fi
start s3684-rs485 --pty --set pace=0
"$tree/tests/bench/roundtrip" pty "$(place)"
"$tree/tests/bench/roundtrip" scpi "$folder/control"
stop
start ocd-ib-k3 --modbus 127.0.0.1:0
port=$(place)
"$tree/tests/bench/roundtrip" modbus "${port##*:}"
idle "ocd-ib-k3 at rest"
stop
for nodes in 1 10 100; do
    start f3668 --slcan --node "1..$nodes"
    figure "kB RSS, f3668 x $nodes" "$(rss)"
    stop
done
start tools/examples/pitch.ini
figure "kB RSS, pitch.ini" "$(rss)"
idle "pitch.ini at rest"
stop
