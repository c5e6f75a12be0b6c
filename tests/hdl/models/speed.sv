// SPDX-License-Identifier: MIT
// A master that clocks 44 bits with 10 MHz, over and over: the encoder's line, or with +define+DUMMY that of dummy.sv.
`timescale 1ns / 1ps
module speed;
  logic ma = 1, slo;
  logic clk = 0;
  int   count = 0, ones = 0;
`ifdef DUMMY
  dummy encoder (.ma, .slo);
`else
  drehgeber_biss #(.SETTINGS("mt=12 st=20 lc=0"), .MOTION("3000RPM")) encoder (.ma, .sli(1'b0), .slo);
`endif
  always #5 clk = !clk;
  always @(posedge clk) begin
    count <= count == 2499 ? 0 : count + 1;
    if (count < 880 && count % 10 == 0) ma <= !ma || count >= 870;
    ones <= ones + int'(slo);
  end
  initial begin
    #20000000;
    $display("simulated_us 20000 ones %0d", ones);
    $finish;
  end
endmodule
