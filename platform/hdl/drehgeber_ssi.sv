// SPDX-License-Identifier: MIT
// An encoder with SSI: one instance, one encoder. See drehgeber_biss.sv.
//
//   drehgeber_ssi #(.SETTINGS("mt=12 st=13 code=gray")) encoder (.clock(clock), .data(data));
//
// A clock that is neither 0 nor 1 counts as 1.
`timescale 1ps / 1ps
/* verilator lint_save */
/* verilator lint_off BLKSEQ */
/* verilator lint_off STMTDLY */
/* verilator lint_off SYNCASYNCNET */
/* verilator lint_off UNUSEDSIGNAL */
module drehgeber_ssi #(
  parameter string MODEL        = "ssi-25",     // drehgeber list
  parameter string SETTINGS     = "",           // KEY=VALUE KEY=VALUE: drehgeber run MODEL --help
  parameter string MOTION       = "",           // 90DEG, 60RPM, sine:90DEG,2S, ramp:3000RPM,1S, FILE.csv
  parameter string MEMORY       = "",           // file of the EEPROM
  parameter real   TCO_NS       = 150.0,        // from an edge of the clock at the encoder to data; above 0
  parameter real   CLOCK_DELAY_NS = 0.0,       // of the cable to the encoder
  parameter real   DATA_DELAY_NS = 0.0,        // of the cable from the encoder
  parameter real   JITTER_NS    = 0.0,          // up to as much more, for each edge either way
  parameter int    SEED         = 1             // of jitter and chance
) (
  input  logic clock,
  output logic data
);
`include "drehgeber_dpi.svh"

  initial data = 1'b1;

  function automatic string settings();
    return $sformatf("tco_ns=%0.3f delay_in_ns=%0.3f delay_out_ns=%0.3f jitter_ns=%0.3f seed=%0d %s", TCO_NS,
                     CLOCK_DELAY_NS, DATA_DELAY_NS, JITTER_NS, SEED, SETTINGS);
  endfunction

  function automatic int inputs();
    return {31'b0, clock !== 1'b0};
  endfunction

  function automatic void outputs(int levels);
    data = levels[0];
  endfunction

  always @(clock or again or asked) look();
endmodule
/* verilator lint_restore */
`timescale 1ns / 1ps // for what is compiled behind it
