// SPDX-License-Identifier: MIT
// Encoders of files in Icarus Verilog, as masters see them that know no more of them than their widths: 26 and 32 bits
// over BiSS, 40 bits over SSI. Position by position, and an error.
`timescale 1ns / 1ps
module sold #(
    parameter NARROW = "",  // files of models
    parameter WIDE = "",
    parameter SSI = "",
    parameter SEED = 1
);
  reg clk = 0, reset = 1;
  always #5 clk = !clk;

  integer checks = 0, errors = 0, seed = SEED, i;
  reg signed [31:0] k;

  task check(input right, input [8*40-1:0] what, input [63:0] is, input [63:0] wanted);
    begin
      checks = checks + 1;
      if (right !== 1'b1) begin
        errors = errors + 1;
        $display("%0t: %0s: %h, not %h", $time, what, is, wanted);
      end
    end
  endtask

  // ---------------------------------------------------------------- BiSS, one after the other
  reg cycle = 0, wide = 0;
  wire ma, frame_done, word_done, n_error, n_warning, crc_ok;
  wire [2:0] frame_status;
  wire [47:0] position;
  wire slo_narrow, slo_wide;
  biss_master #(.CLK_HZ(100000000), .SLAVES(1)) master (
      .clk(clk), .reset(reset), .ma_half(12'd5), .slave_count(4'd1), .position_bits(wide ? 6'd32 : 6'd26),
      .life_counter(1'b0), .cycle(cycle), .latch(), .frame_done(frame_done), .frame_status(frame_status),
      .line_delay(), .word_done(word_done), .word_slave(), .word_position(position), .word_n_error(n_error),
      .word_n_warning(n_warning), .word_life(), .word_crc_ok(crc_ok), .register_start(1'b0),
      .register_write(1'b0), .register_id(3'd0), .register_address(7'd0), .register_wdata(8'd0),
      .register_more(1'b0), .register_busy(), .register_done(), .register_rdata(), .register_status(),
      .ma(ma), .sl(wide ? slo_wide : slo_narrow));
  drehgeber_biss #(.MODEL(NARROW)) narrow_encoder (.ma(ma || wide), .slo(slo_narrow), .sli(1'b0));
  drehgeber_biss #(.MODEL(WIDE)) wide_encoder (.ma(ma || !wide), .slo(slo_wide), .sli(1'b0));

  reg [47:0] seen;
  reg [2:0] flags;
  always @(negedge clk) if (word_done) {seen, flags} = {position, crc_ok, n_error, n_warning};

  task frame(input [47:0] wanted, input [2:0] wanted_flags);
    begin
      @(negedge clk) cycle = 1;
      @(negedge clk);
      while (!frame_done) @(negedge clk);
      cycle = 0;
      @(negedge clk);
      check(frame_status == 0, "frame", frame_status, 0);
      check(seen == wanted, "position", seen, wanted);
      check(flags == wanted_flags, "CRC nERR nWARN", flags, wanted_flags);
    end
  endtask

  // ---------------------------------------------------------------- SSI
  reg ssi_cycle = 0;
  wire clock, data, ssi_done, parity_ok;
  wire [1:0] ssi_status;
  wire [39:0] ssi_position;
  ssi_master #(.CLK_HZ(100000000), .WORD_MAX(40)) ssi (
      .clk(clk), .reset(reset), .clock_half(12'd50), .sample_delay(12'd60), .pause_us(8'd25),
      .position_bits(6'd40), .gray(1'b1), .has_error(1'b0), .has_parity(1'b0), .parity_odd(1'b0),
      .cycle(ssi_cycle), .latch(), .done(ssi_done), .status(ssi_status), .word(), .position(ssi_position),
      .error(), .parity_ok(parity_ok), .clock(clock), .data(data));
  drehgeber_ssi #(.MODEL(SSI)) ssi_encoder (.clock(clock), .data(data));

  task ssi_word(input [39:0] wanted);
    begin
      @(negedge clk) ssi_cycle = 1;
      @(negedge clk);
      while (!ssi_done) @(negedge clk);
      ssi_cycle = 0;
      check(ssi_status == 0, "SSI status", ssi_status, 0);
      check(ssi_position == wanted, "SSI position", ssi_position, wanted);
    end
  endtask

  // ---------------------------------------------------------------- what happens
  initial begin
    #220 reset = 0;
    for (i = 0; i < 8; i = i + 1) begin
      k = $random(seed);  // in 2^-20 turns: +-2048, of which an encoder without turns has the last 20 bits
      narrow_encoder.turn(k / 1048576.0);
      wide_encoder.turn(k / 1048576.0);
      ssi_encoder.turn(k / 1048576.0);
      wide = 0;
      frame({k[19:0], 6'b0}, 7);
      wide = 1;
      frame({k[19:0], 12'b0}, 7);
      ssi_word({{4{k[31]}}, k, 4'b0});
    end
    narrow_encoder.fault("watchdog_fired", 1'b1);
    wide = 0;
    frame({k[19:0], 6'b0}, 5);
    if (errors == 0) $display("passed %0d checks in %0d us", checks, $time / 1000);
    $finish;
  end
endmodule
