// SPDX-License-Identifier: MIT
// A test bench of ../verilator/master.v for Icarus Verilog, with the VPI model: an encoder that turns, whose processing time
// is another one in every frame, and which then has a defect. Ends with `ok`, or with an exit status of 1.
`timescale 1ns / 1ps
module tb;
  reg clk = 0, reset = 1, start = 0;
  wire ma, slo, done, good, error, warning;
  wire [31:0] position;
  real latched;
  integer i;
  always #5 clk = !clk;

  master #(.BITS(32)) dut (
      .clk(clk), .reset(reset), .start(start), .ma(ma), .slo(slo), .done(done), .good(good), .error(error),
      .warning(warning), .position(position));

  drehgeber_biss #(
      .SETTINGS("mt=12 st=20 lc=0 busy_us=2 busy_jitter_us=5"), .MOTION("3000RPM"), .SLO_DELAY_NS(20.0)
  ) encoder (.ma(ma), .sli(1'b0), .slo(slo));

  task read_position(input in_order);
    begin
      @(negedge clk) start = 1;
      @(negedge clk) start = 0;
      @(posedge done);
      @(negedge clk);
      encoder.latched(latched);
      if (!good || position != latched || error == in_order)
        $fatal(1, "good %b error %b position %0d, was latched: %0.0f", good, error, position, latched);
    end
  endtask

  initial begin
    repeat (4) @(negedge clk);
    reset = 0;
    for (i = 0; i < 50; i = i + 1) read_position(1);
    for (i = 0; i < 50; i = i + 1) begin
      encoder.turn(i * 0.7321);
      read_position(1);
    end
    encoder.fault("led_current_high", 1);
    read_position(0);
    encoder.fault("led_current_high", 0);
    read_position(1);
    $display("ok");
    $finish;
  end
endmodule
