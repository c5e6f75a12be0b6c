// SPDX-License-Identifier: MIT
// Pins, for tests that are the master themselves.
`timescale 1ns / 1ps
module pins (
    input wire ma, slo, sli,
    input wire tx, rx, de
);
endmodule
