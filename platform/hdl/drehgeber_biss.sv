// SPDX-License-Identifier: MIT
// An encoder with BiSS-C: one instance, one encoder. For simulators with DPI-C: Verilator 5 (--timing), Questa,
// Xcelium, VCS, Riviera. README.md in this folder has parameters, tasks and what to link.
//
//   drehgeber_biss #(.SETTINGS("busy_us=5 busy_jitter_us=3")) encoder (.ma(ma), .sli(1'b0), .slo(slo));
//
// A chain: slo of the next encoder goes into sli; the last one has 0 there. MA and SLI that are neither 0 nor 1 count
// as 1 and 0.
`timescale 1ps / 1ps
/* verilator lint_save */
/* verilator lint_off BLKSEQ */
/* verilator lint_off STMTDLY */
/* verilator lint_off SYNCASYNCNET */
/* verilator lint_off UNUSEDSIGNAL */
module drehgeber_biss #(
  parameter string MODEL        = "s3684-biss", // drehgeber list
  parameter string SETTINGS     = "",           // KEY=VALUE KEY=VALUE: drehgeber run MODEL --help
  parameter string MOTION       = "",           // 90DEG, 60RPM, sine:90DEG,2S, ramp:3000RPM,1S, FILE.csv
  parameter string MEMORY       = "",           // file of the EEPROM
  parameter real   TCO_NS       = 10.0,         // from an edge of MA at the encoder to SLO; above 0
  parameter real   MA_DELAY_NS  = 0.0,          // of the cable to the encoder
  parameter real   SLO_DELAY_NS = 0.0,          // of the cable from the encoder
  parameter real   JITTER_NS    = 0.0,          // up to as much more, for each edge either way
  parameter int    SEED         = 1             // of jitter and chance
) (
  input  logic ma,
  input  logic sli,
  output logic slo
);
`include "drehgeber_dpi.svh"

  initial slo = 1'b1;

  function automatic string settings();
    return $sformatf("tco_ns=%0.3f delay_in_ns=%0.3f delay_out_ns=%0.3f jitter_ns=%0.3f seed=%0d %s", TCO_NS,
                     MA_DELAY_NS, SLO_DELAY_NS, JITTER_NS, SEED, SETTINGS);
  endfunction

  function automatic int inputs();
    return {30'b0, sli === 1'b1, ma !== 1'b0};
  endfunction

  function automatic void outputs(int levels);
    slo = levels[0];
  endfunction

  always @(ma or sli or again or asked) look();
endmodule
/* verilator lint_restore */
`timescale 1ns / 1ps // for what is compiled behind it
