# SPDX-License-Identifier: MIT
# Read by the shell that runs a block of a page: DOCS_STARTED takes what goes on running, DOCS_LINE the
# line that failed.
trap 'echo "$LINENO" >"$DOCS_LINE"' ERR

# background COMMAND...: an encoder or a rig, as the reader runs it in a second terminal. Goes on when it is
# ready and has said all that belongs to that: the other encoders, the control addresses.
background() {
    local log ready='^ready' size=
    log=$(mktemp)
    [[ " $* " != *.ini\ * ]] || ready='^ready rig'
    "$@" >"$log" 2>&1 &
    echo "$! $log $*" >>"$DOCS_STARTED"
    until grep -q "$ready" "$log" && [ "$size" = "$(stat -c %s "$log")" ]; do
        size=$(stat -c %s "$log")
        kill -0 "$!" 2>/dev/null || break
        sleep 0.1
    done
    cat "$log"
    # Not the last command's status: the line that failed is the caller's.
    kill -0 "$!" 2>/dev/null || wait "$!" || return
}
