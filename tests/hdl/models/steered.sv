// SPDX-License-Identifier: MIT
// An encoder that somebody else steers over its control socket: what a master sees of each frame, a line of text when
// that changes. It is over when the shaft is at 0, which a single wrong bit does not make of 135 degrees.
`timescale 1ns / 1ps
module steered;
  logic ma = 1'b1;
  wire slo;
  string seen = "";
  string now;
  logic [59:0] bits;  // MT 12, ST 20, nERR, nWARN, CRC, and zeros behind them
  logic [59:0] healthy;
  int clocks;

  drehgeber_biss #(.SETTINGS("mt=12 st=20 lc=0 control=unix:steered.sock"), .MOTION("135DEG")) encoder (
      .ma(ma), .sli(1'b0), .slo(slo));

  task automatic pulse();
    #500 ma = 1'b0;
    #500 ma = 1'b1;
    #400;
  endtask

  task automatic frame();
    logic ack;
    clocks = 0;
    pulse();
    pulse();
    ack = !slo;
    do begin
      pulse();
      clocks++;
    end while (!slo && clocks < 400);
    pulse();
    repeat (60) begin
      pulse();
      bits = {bits[58:0], slo};
    end
    #30000;
    now = !ack ? "silent" : clocks > 60 ? "late" : "good";
  endtask

  initial begin
    frame();
    healthy = bits;
    while (now != "good" || bits[59:28] != 0) begin
      if (now == "good" && bits != healthy) now = $countones(bits ^ healthy) == 1 ? "damaged" : "moved";
      if (now != seen) $display("%s", now);
      $fflush;
      seen = now;
      frame();
    end
    $display("done");
    $finish;
  end
endmodule
