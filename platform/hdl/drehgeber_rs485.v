// SPDX-License-Identifier: MIT
// An encoder with RS485 and SinCos for Icarus Verilog: one instance, one encoder. See drehgeber_vpi.c for what to
// compile, and drehgeber_rs485.sv for simulators with DPI-C, whose parameters and ports are the same.
`timescale 1ps / 1ps
module drehgeber_rs485 #(
  parameter MODEL        = "s3684-rs485",// drehgeber list
  parameter SETTINGS     = "",           // KEY=VALUE KEY=VALUE: drehgeber run MODEL --help
  parameter MOTION       = "",           // 90DEG, 60RPM, sine:90DEG,2S, ramp:3000RPM,1S, FILE.csv
  parameter MEMORY       = "",           // file of the EEPROM
  parameter TCO_NS       = 10.0,         // from a bit at the encoder to tx; above 0
  parameter RX_DELAY_NS  = 0.0,          // of the cable to the encoder
  parameter TX_DELAY_NS  = 0.0,          // of the cable from the encoder
  parameter JITTER_NS    = 0.0,          // up to as much more, for each edge either way
  parameter SINCOS_NS    = 1000.0,       // how often sine and cosine are renewed; 0: they stay 0
  parameter SEED         = 1             // of jitter and chance
) (
  input            rx,
  output           tx,
  output           de,
  output wire real sine,
  output wire real cosine
);
  wire [31:0] inputs = {31'b0, rx !== 1'b0};
`include "drehgeber_vpi.vh"
  assign tx = levels[0];
  assign de = levels[1];

  real sine_now;
  real cosine_now;
  assign sine = sine_now;
  assign cosine = cosine_now;
  initial begin
    sine_now = 0.0;
    cosine_now = 0.0;
    if (SINCOS_NS > 0.0) forever begin
      #(1000.0 * SINCOS_NS);
      $drehgeber_real(id, 3, sine_now);
      $drehgeber_real(id, 4, cosine_now);
    end
  end

  reg [8*512-1:0] settings;
  task make;
    if (id === 32'bx) begin
      $sformat(settings, "tco_ns=%0.3f delay_in_ns=%0.3f delay_out_ns=%0.3f jitter_ns=%0.3f seed=%0d %0s", TCO_NS,
               RX_DELAY_NS, TX_DELAY_NS, JITTER_NS, SEED, SETTINGS);
      id = $drehgeber_make(MODEL, settings, MOTION, MEMORY);
    end
  endtask
endmodule
`timescale 1ns / 1ps // for what is compiled behind it
