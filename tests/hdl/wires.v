// SPDX-License-Identifier: MIT
// The masters in Verilog and the models for Icarus Verilog: positions and a register on one wire. Parameters are the
// wire; what is expected is worked out from the angle.
`timescale 1ns / 1ps
module wires #(
    parameter CLOCK_NS = 10,  // of the masters
    parameter HALF = 5,       // half a period of MA, in clocks
    parameter CABLE_NS = 10,  // each way
    parameter SETTINGS = "busy_us=3",
    parameter CHAIN = 1,
    parameter SEED = 1,
    parameter FRAMES = 4
);
  reg clk = 0, reset = 1;
  always #(CLOCK_NS / 2) clk = !clk;
  localparam real DELAY_NS = CABLE_NS;

  integer checks = 0, errors = 0, seed = SEED;

  task check(input right, input [8*40-1:0] what, input [63:0] is, input [63:0] wanted);
    begin
      checks = checks + 1;
      if (right !== 1'b1) begin
        errors = errors + 1;
        $display("%0t: %0s: %h, not %h", $time, what, is, wanted);
      end
    end
  endtask

  // ---------------------------------------------------------------- BiSS: MT 12 and ST 21 in each slot
  reg cycle = 0, start = 0, write = 0;
  reg [2:0] id = 0;
  reg [6:0] address = 0;
  reg [7:0] wdata = 0;
  wire ma, busy, done, frame_done, word_done, n_error, n_warning, crc_ok;
  wire [2:0] frame_status, slave, status;
  wire [47:0] position;
  wire [5:0] life;
  wire [7:0] rdata;
  wire [2:0] slo;

  biss_master #(.CLK_HZ(1000000000 / CLOCK_NS), .SLAVES(3)) master (
      .clk(clk), .reset(reset), .ma_half(HALF[11:0]), .slave_count(CHAIN[3:0]), .position_bits({3{6'd33}}),
      .life_counter(3'b111), .cycle(cycle), .latch(), .frame_done(frame_done), .frame_status(frame_status),
      .line_delay(), .word_done(word_done), .word_slave(slave), .word_position(position), .word_n_error(n_error),
      .word_n_warning(n_warning), .word_life(life), .word_crc_ok(crc_ok), .register_start(start),
      .register_write(write), .register_id(id), .register_address(address), .register_wdata(wdata),
      .register_more(1'b0), .register_busy(busy), .register_done(done), .register_rdata(rdata),
      .register_status(status), .ma(ma), .sl(slo[0]));
  drehgeber_biss #(.SETTINGS(SETTINGS), .MA_DELAY_NS(DELAY_NS), .SLO_DELAY_NS(DELAY_NS), .JITTER_NS(2.0)) first (
      .ma(ma), .slo(slo[0]), .sli(CHAIN > 1 && slo[1]));
  drehgeber_biss #(.SETTINGS(SETTINGS), .MA_DELAY_NS(DELAY_NS)) second (
      .ma(ma), .slo(slo[1]), .sli(CHAIN > 2 && slo[2]));
  drehgeber_biss #(.SETTINGS(SETTINGS), .MA_DELAY_NS(DELAY_NS)) third (.ma(ma), .slo(slo[2]), .sli(1'b0));

  reg [32:0] expected[0:2];  // of 4096 turns of 2^21
  integer words = 0, frames = 0;
  reg bent = 0;  // by a fault: what is wrong is counted
  integer wrong = 0;

  always @(negedge clk) begin
    if (word_done && bent) begin
      if (!crc_ok) begin
        wrong = wrong + 1;
        check(slave == 0, "slave with a wrong CRC", slave, 0);
      end
    end else if (word_done) begin
      check(slave == words, "slave", slave, words);
      check(crc_ok && n_error && n_warning, "CRC nERR nWARN", {crc_ok, n_error, n_warning}, 7);
      check(position == expected[words], "position", position, expected[words]);
      // 0 once, in the first frame.
      check(life == (frames == 0 ? 0 : (frames - 1) % 63 + 1), "LC", life, frames);
      words = words + 1;
    end
    if (frame_done) begin
      if (!bent) check(frame_status == 0 && words == CHAIN, "frame", {frame_status, words}, CHAIN);
      words = 0;
      frames = frames + 1;
    end
  end

  task frame;
    begin
      @(negedge clk) cycle = 1;
      @(negedge clk);
      while (!frame_done) @(negedge clk);
      cycle = 0;
      @(negedge clk);
    end
  endtask

  // A frame with a fault behind the first encoder's driver, and the next one without.
  task bent_frame(input [8*16-1:0] name, input [2:0] wanted_status, input integer wanted_wrong);
    begin
      bent = 1;
      wrong = 0;
      frame;
      check(frame_status == wanted_status, name, frame_status, wanted_status);
      check(wrong == wanted_wrong, name, wrong, wanted_wrong);
      bent = 0;
    end
  endtask

  task access(input w, input [2:0] slave_id, input [6:0] at, input [7:0] data, input [7:0] wanted);
    begin
      @(negedge clk) {cycle, start, write, id, address, wdata} = {1'b1, 1'b1, w, slave_id, at, data};
      @(negedge clk) start = 0;
      while (!done) @(negedge clk);
      check(status == 0 && rdata == wanted, "register", {status, rdata}, wanted);
      while (!frame_done) @(negedge clk);
      cycle = 0;
    end
  endtask

  // ---------------------------------------------------------------- SSI: 25 bits in Gray code; 28 with error and parity
  reg ssi_cycle = 0, plain = 0;
  wire clock, data_gray, data_plain, ssi_done, ssi_error, parity_ok;
  wire [1:0] ssi_status;
  wire [33:0] ssi_position;
  localparam LATE = HALF * CLOCK_NS < 500 ? 2 : 1;  // clocks in a microsecond

  localparam [11:0] CLOCK_HALF = HALF * CLOCK_NS < 250 ? 250 / CLOCK_NS : HALF;
  localparam [11:0] SAMPLE_DELAY = 400 / CLOCK_NS;
  ssi_master #(.CLK_HZ(1000000000 / CLOCK_NS)) ssi (
      .clk(clk), .reset(reset), .clock_half(CLOCK_HALF), .sample_delay(SAMPLE_DELAY), .pause_us(8'd22),
      .position_bits(plain ? 6'd28 : 6'd25), .gray(!plain), .has_error(plain), .has_parity(plain), .parity_odd(1'b0),
      .cycle(ssi_cycle), .latch(), .done(ssi_done), .status(ssi_status), .word(), .position(ssi_position),
      .error(ssi_error), .parity_ok(parity_ok), .clock(clock), .data(plain ? data_plain : data_gray));
  drehgeber_ssi #(.MODEL("ssi-25"), .CLOCK_DELAY_NS(DELAY_NS), .DATA_DELAY_NS(DELAY_NS)) gray_encoder (
      .clock(clock || plain), .data(data_gray));
  drehgeber_ssi #(.MODEL("ssi-28"), .CLOCK_DELAY_NS(DELAY_NS), .DATA_DELAY_NS(DELAY_NS)) plain_encoder (
      .clock(clock || !plain), .data(data_plain));

  task ssi_any;
    begin
      @(negedge clk) ssi_cycle = 1;
      @(negedge clk);
      while (!ssi_done) @(negedge clk);
      ssi_cycle = 0;
    end
  endtask

  task ssi_word(input [1:0] wanted_status, input [33:0] wanted, input wanted_error);
    begin
      ssi_any;
      check(ssi_status == wanted_status, "SSI status", ssi_status, wanted_status);
      if (wanted_status == 0) begin
        check(ssi_position == wanted, "SSI position", ssi_position, wanted);
        check(ssi_error == wanted_error && parity_ok, "SSI error, parity", {ssi_error, parity_ok}, {wanted_error, 1'b1});
      end
    end
  endtask

  // ---------------------------------------------------------------- what happens
  integer i, j, k;
  initial begin
    #20; // power comes after 1 ns, and the line follows after 10
    check(slo[0] === 1'b0, "SLO before the first pulse", slo[0], 0);
    #200 reset = 0;
    for (i = 0; i < FRAMES; i = i + 1) begin
      for (j = 0; j < 3; j = j + 1) begin
        k = $random(seed);  // in 2^-19 turns: +-4096
        expected[j] = {k, 2'b00};
        case (j)
          0: first.turn(k / 524288.0);
          1: second.turn(k / 524288.0);
          default: third.turn(k / 524288.0);
        endcase
      end
      frame;
    end
    // ID 0 is the last one.
    if (SEED % 2 == 0) access(0, 3'd0, 7'h7E, 0, 8'h4B);
    else access(1, CHAIN[2:0] - 3'd1, 7'h22, 8'hA5, 8'hA5);
    first.fault("wire_drop", 1'b1);
    bent_frame("wire_drop", 1, 0);
    first.fault("wire_drop", 1'b0);
    frame;
    first.fault("wire_delay", 1'b1);
    bent_frame("wire_delay", 2, 0);
    first.fault("wire_delay", 1'b0);
    frame;
    first.fault("wire_damage", 1'b1);
    for (i = 0; i < 4; i = i + 1) bent_frame("wire_damage", 0, 1);
    first.fault("wire_damage", 1'b0);
    frame;
    first.fault("wire_break", 1'b1);
    #1000 check(slo[0] === 1'b1, "SLO that is cut", slo[0], 1);
    bent_frame("wire_break", 1, 0);
    first.fault("wire_break", 1'b0);
    frame;
    for (i = 0; i < 4; i = i + 1) begin
      k = $random(seed);  // in 2^-12 turns
      gray_encoder.turn(k / 4096.0);
      plain_encoder.turn(k / 4096.0);
      plain = 0;
      ssi_word(0, {k[23:0], 1'b0}, 0);
      plain = 1;
      ssi_word(0, {k[23:0], 4'b0000}, 0);
    end
    plain_encoder.fault("led_current_high", 1'b1);
    ssi_word(0, {k[23:0], 4'b0000}, 1);
    plain_encoder.fault("led_current_high", 1'b0);
    ssi_word(0, {k[23:0], 4'b0000}, 0);
    plain_encoder.turn(0.25);
    plain_encoder.fault("wire_drop", 1'b1);
    ssi_word(0, 0, 0);
    plain_encoder.fault("wire_drop", 1'b0);
    ssi_word(0, 28'h0004000, 0);
    plain_encoder.fault("wire_delay", 1'b1);
    ssi_any;
    check(ssi_position == (LATE == 1 ? 28'h8002000 : 28'hC001000), "SSI late", ssi_position,
          LATE == 1 ? 28'h8002000 : 28'hC001000);
    plain_encoder.fault("wire_delay", 1'b0);
    ssi_word(0, 28'h0004000, 0);
    plain_encoder.fault("wire_damage", 1'b1);
    ssi_any;
    check(!parity_ok, "SSI parity of a damaged word", parity_ok, 0);
    plain_encoder.fault("wire_damage", 1'b0);
    ssi_word(0, 28'h0004000, 0);
    plain_encoder.fault("wire_break", 1'b1);
    #1000;
    ssi_word(1, 0, 0);
    plain_encoder.fault("wire_break", 1'b0);
    #1000;
    ssi_word(0, 28'h0004000, 0);
    plain_encoder.power(1'b0);
    #1000;
    ssi_word(1, 0, 0);
    if (errors != 0) $display("%0d of %0d checks failed", errors, checks);
    else $display("passed %0d checks in %0d us", checks, $time / 1000);
    $finish;
  end
endmodule
