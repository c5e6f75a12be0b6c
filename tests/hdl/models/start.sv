// SPDX-License-Identifier: MIT
// The first nanoseconds in every simulator with Verilog: what registers of a master do there is no pulse of MA. start.vhd
// does the same. A line of text for each encoder at 99 us: what SLO is, which is 1 behind a pulse.
`timescale 1ns / 1ps
module start;
  reg zero, unknown, pulsing, late;  // X in Icarus Verilog, 0 in Verilator
  reg at_once = 0;
  wire of_zero, of_unknown, of_pulsing, of_at_once, of_late, near, far, data;

  drehgeber_biss a (.ma(zero), .sli(1'b0), .slo(of_zero));
  drehgeber_biss b (.ma(unknown), .sli(1'b0), .slo(of_unknown));
  drehgeber_biss #(.MA_DELAY_NS(20.0)) c (.ma(at_once), .sli(1'b0), .slo(of_at_once));
  drehgeber_biss d (.ma(pulsing), .sli(1'b0), .slo(of_pulsing));
  drehgeber_biss #(.SETTINGS("power_on_ns=20")) e (.ma(late), .sli(1'b0), .slo(of_late));
  drehgeber_biss f (.ma(1'b1), .sli(far), .slo(near));
  drehgeber_biss g (.ma(1'b1), .sli(1'b0), .slo(far));
  drehgeber_ssi #(.MOTION("90DEG")) h (.clock(at_once), .data(data));

  initial begin
    zero = 0;
    at_once = 1;
    pulsing = 1;
    late = 1;
    #3 late = 0;
    #2 zero = 1;
    unknown = 1;
    late = 1;
    pulsing = 0;
    #5 pulsing = 1;
    #98990 $display("zero %b", of_zero);
    $display("unknown %b", of_unknown);
    $display("at_once %b", of_at_once);
    $display("pulsing %b", of_pulsing);
    $display("late %b", of_late);
    $display("near %b", near);
    $display("data %b", data);
    #2000 $display("done");
    $finish;
  end
endmodule
