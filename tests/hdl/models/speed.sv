// SPDX-License-Identifier: MIT
// A master that clocks 44 bits with 10 MHz, over and over, and nothing else: what is counted is not a clock of the
// bench. The encoder's line, or with +define+DUMMY that of dummy.sv.
`timescale 1ns / 1ps
module speed;
  localparam int FRAMES = 40000; // about a second of CPU
  logic ma = 1, slo;
  int   ones = 0;
`ifdef DUMMY
  dummy encoder (.ma, .slo);
`else
  drehgeber_biss #(.SETTINGS("mt=12 st=20 lc=0 busy_us=0"), .MOTION("3000RPM")) encoder (.ma, .sli(1'b0), .slo);
`endif
  initial begin
    repeat (FRAMES) begin
      repeat (44) begin
        #50 ma = 0;
        #50 ma = 1;
        ones += int'(slo);
      end
      #20600;
    end
    $display("simulated_us %0d ones %0d", 25 * FRAMES, ones);
    $finish;
  end
endmodule
