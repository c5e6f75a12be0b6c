// SPDX-License-Identifier: MIT
// A simulation that is over before a master has clocked.
`timescale 1ns / 1ps
module short;
  wire slo;
  drehgeber_biss encoder (.ma(1'b1), .sli(1'b0), .slo(slo));
  initial begin
    #1000 $display("done");
    $finish;
  end
endmodule
