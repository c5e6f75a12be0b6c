// SPDX-License-Identifier: MIT
// A test bench of master.v against an encoder that turns, whose processing time is another one in every frame, and
// which then has a defect. Ends with `ok`, or fails.
`timescale 1ns / 1ps
module tb;
  logic clk = 0, reset = 1, start = 0, ma, slo, done, good, error, warning;
  logic [31:0] position;
  always #5 clk = !clk;

  master #(.BITS(32)) dut (.*);

  drehgeber_biss #(
    .SETTINGS("mt=12 st=20 lc=0 busy_us=2 busy_jitter_us=5"),
    .MOTION("3000RPM"), .SLO_DELAY_NS(20.0)
  ) encoder (.ma(ma), .sli(1'b0), .slo(slo));

  task automatic read();
    @(negedge clk) start = 1;
    @(negedge clk) start = 0;
    @(posedge done);
    @(negedge clk);
  endtask

  task automatic expect_position(bit in_order);
    read();
    if (!good || position != 32'(encoder.latched()) || error == in_order)
      $fatal(1, "good %b error %b position %h, was latched: %h", good, error, position, encoder.latched());
  endtask

  initial begin
    repeat (4) @(negedge clk);
    reset = 0;
    for (int i = 0; i < 200; i++) expect_position(1);
    for (int i = 0; i < 200; i++) begin
      encoder.turn(real'(i) * 0.7321);
      expect_position(1);
    end
    encoder.fault("led_current_high");
    expect_position(0);
    encoder.fault("led_current_high", 0);
    expect_position(1);
    encoder.power(0);
    read();
    if (good) $fatal(1, "an encoder without power has answered");
    $display("ok");
    $finish;
  end
endmodule
