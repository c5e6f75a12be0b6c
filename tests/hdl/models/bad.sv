// SPDX-License-Identifier: MIT
// An encoder whose settings are wrong.
`timescale 1ns / 1ps
module bad;
  wire slo;
  drehgeber_biss #(.SETTINGS("st=99")) encoder (.ma(1'b1), .sli(1'b0), .slo(slo));
  initial #1000 $display("done");
endmodule
