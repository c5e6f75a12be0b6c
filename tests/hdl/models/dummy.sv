// SPDX-License-Identifier: MIT
// What stands in a test bench in place of an encoder that there is none of: the same frame each time, without
// registers, processing time or faults. What it costs is the yardstick for what the encoder costs.
`timescale 1ns / 1ps
module dummy (
  input  logic ma,
  output logic slo
);
  localparam logic [43:0] FRAME = {2'b11, 1'b0, 1'b1, 1'b0, 32'h12345678, 2'b11, 5'b0};
  logic [43:0] shift = FRAME;
  realtime last = 0;
  initial slo = 1'b1;
  always @(posedge ma) begin
    shift = $realtime - last > 13000.0 ? FRAME : {shift[42:0], 1'b0};
    last = $realtime;
    slo <= #10 shift[43];
  end
endmodule
