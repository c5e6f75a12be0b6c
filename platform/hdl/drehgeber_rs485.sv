// SPDX-License-Identifier: MIT
// An encoder with RS485 and SinCos: one instance, one encoder. See drehgeber_biss.sv.
//
//   drehgeber_rs485 #(.SETTINGS("address=40h")) encoder (.rx(to_encoder), .tx(from_encoder), .de(drives));
//
// rx is what the master sends, tx what the encoder sends while its driver is enabled, de; both are 1 in between. Data
// rate and parity are those that the encoder has at the moment. sine and cosine are the differences sin+ - sin- and cos+ -
// cos- in volts, of the same shaft as the position that 42h gives, at any moment: renewed every SINCOS_NS; in between they stay.
`timescale 1ps / 1ps
/* verilator lint_save */
/* verilator lint_off BLKSEQ */
/* verilator lint_off STMTDLY */
/* verilator lint_off SYNCASYNCNET */
/* verilator lint_off UNUSEDSIGNAL */
module drehgeber_rs485 #(
  parameter string MODEL        = "s3684-rs485",// drehgeber list
  parameter string SETTINGS     = "",           // KEY=VALUE KEY=VALUE: drehgeber run MODEL --help
  parameter string MOTION       = "",           // 90DEG, 60RPM, sine:90DEG,2S, ramp:3000RPM,1S, FILE.csv
  parameter string MEMORY       = "",           // file of the EEPROM
  parameter real   TCO_NS       = 10.0,         // from a bit at the encoder to tx; above 0
  parameter real   RX_DELAY_NS  = 0.0,          // of the cable to the encoder
  parameter real   TX_DELAY_NS  = 0.0,          // of the cable from the encoder
  parameter real   JITTER_NS    = 0.0,          // up to as much more, for each edge either way
  parameter real   SINCOS_NS    = 1000.0,       // 0: sine and cosine stay 0
  parameter int    SEED         = 1             // of jitter and chance
) (
  input  logic rx,
  output logic tx,
  output logic de,
  output real  sine,
  output real  cosine
);
`include "drehgeber_dpi.svh"

  initial begin
    tx = 1'b1;
    de = 1'b0;
    sine = 0.0;
    cosine = 0.0;
  end

  function automatic string settings();
    return $sformatf("tco_ns=%0.3f delay_in_ns=%0.3f delay_out_ns=%0.3f jitter_ns=%0.3f seed=%0d %s", TCO_NS,
                     RX_DELAY_NS, TX_DELAY_NS, JITTER_NS, SEED, SETTINGS);
  endfunction

  function automatic int inputs();
    return {31'b0, rx !== 1'b0};
  endfunction

  function automatic void outputs(int levels);
    tx = levels[0];
    de = levels[1];
  endfunction

  always @(rx or again or asked) look();

  function automatic real volts(int plus);
    return dg_hdl_volts(encoder, now_ps(), plus) - dg_hdl_volts(encoder, now_ps(), plus + 1);
  endfunction

  if (SINCOS_NS > 0.0) begin : g_sincos
    always begin
      #(1000.0 * SINCOS_NS);
      sine = volts(0);
      cosine = volts(2);
    end
  end
endmodule
/* verilator lint_restore */
`timescale 1ns / 1ps // for what is compiled behind it
