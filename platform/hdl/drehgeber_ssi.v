// SPDX-License-Identifier: MIT
// An encoder with SSI for Icarus Verilog: one instance, one encoder. See drehgeber_vpi.c for what to compile, and
// drehgeber_ssi.sv for simulators with DPI-C, whose parameters and ports are the same.
`timescale 1ps / 1ps
module drehgeber_ssi #(
  parameter MODEL        = "ssi-25",     // drehgeber list
  parameter SETTINGS     = "",           // KEY=VALUE KEY=VALUE: drehgeber run MODEL --help
  parameter MOTION       = "",           // 90DEG, 60RPM, sine:90DEG,2S, ramp:3000RPM,1S, FILE.csv
  parameter MEMORY       = "",           // file of the EEPROM
  parameter TCO_NS       = 150.0,        // from an edge of the clock at the encoder to data; above 0
  parameter CLOCK_DELAY_NS = 0.0,        // of the cable to the encoder
  parameter DATA_DELAY_NS  = 0.0,        // of the cable from the encoder
  parameter JITTER_NS    = 0.0,          // up to as much more, for each edge either way
  parameter SEED         = 1             // of jitter and chance
) (
  input  clock,
  output data
);
  wire [31:0] inputs = {31'b0, clock !== 1'b0};
`include "drehgeber_vpi.vh"
  assign data = levels[0];

  reg [8*512-1:0] settings;
  task make;
    if (id === 32'bx) begin
      $sformat(settings, "tco_ns=%0.3f delay_in_ns=%0.3f delay_out_ns=%0.3f jitter_ns=%0.3f seed=%0d %0s", TCO_NS,
               CLOCK_DELAY_NS, DATA_DELAY_NS, JITTER_NS, SEED, SETTINGS);
      id = $drehgeber_make(MODEL, settings, MOTION, MEMORY);
    end
  endtask
endmodule
`timescale 1ns / 1ps // for what is compiled behind it
