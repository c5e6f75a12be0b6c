// SPDX-License-Identifier: MIT
// The BiSS-C master of platform/hdl/master against the encoders of platform/hdl, on one wire, as a script says:
// test_matrix.py writes it and has the commands.
//
// +script=FILE  lines `COMMAND TEXT A B C D`                +half=N      half a period of MA in clocks of 10 ns
// +delay=NS     of the cable, each way, up to 50            +busy=0..3   0, 3, 5.5, 20 us
// +chain=1..3   encoders                                    +seed=N
// +trace=FILE   what goes into the master and comes out of it, for replay.vhd
//
// What is expected is worked out here and in the script, from the angle and from the manual; the model is not asked.
`timescale 1ns / 1ps

// Three encoders, of which the first `count` are on the line; each of another layout, jitter on the second.
module biss_chain #(
    parameter string SETTINGS = ""
) (
    input logic ma,
    input logic [3:0] count,
    output logic slo
);
  logic second_slo, third_slo;

  drehgeber_biss #(.MODEL("s3684-biss"), .SETTINGS({"serial=1001 ", SETTINGS})) first (
      .ma, .slo, .sli(count > 1 && second_slo)
  );
  drehgeber_biss #(.MODEL("s3674-biss"), .SETTINGS({"serial=1002 st=17 lc=0 ", SETTINGS}), .JITTER_NS(4)) second (
      .ma, .slo(second_slo), .sli(count > 2 && third_slo)
  );
  drehgeber_biss #(.MODEL("s3684-biss"), .SETTINGS({"serial=1003 mt=8 st=24 ", SETTINGS}), .TCO_NS(30)) third (
      .ma, .slo(third_slo), .sli(1'b0)
  );

  task automatic move(int slot, real turns, real rpm);
    case (slot)
      0: begin
        first.turn(turns);
        first.speed(rpm);
      end
      1: begin
        second.turn(turns);
        second.speed(rpm);
      end
      default: begin
        third.turn(turns);
        third.speed(rpm);
      end
    endcase
  endtask
endmodule

module biss_bench;
  localparam int MT[3] = '{12, 0, 8};
  localparam int ST[3] = '{21, 17, 24};
  localparam bit LC[3] = '{1, 0, 1};
  localparam int BUSY_NS[4] = '{0, 3000, 5500, 20000};

  // ---------------------------------------------------------------- master
  logic clk = 0, reset = 1;
  logic [11:0] half;
  logic [3:0] count;
  logic cycle = 0, start = 0, write = 0, more = 0;
  logic [2:0] id = 0;
  logic [6:0] address = 0;
  logic [7:0] wdata = 0;
  wire ma, latch, frame_done, word_done, n_error, n_warning, crc_ok, busy, done;
  wire [2:0] frame_status, slave, status;
  wire [11:0] line_delay;
  wire [47:0] position;
  wire [5:0] life;
  wire [7:0] rdata;
  logic sl;

  biss_master #(.SLAVES(3)) master (
      .clk, .reset, .ma_half(half), .slave_count(count), .position_bits({6'd32, 6'd17, 6'd33}), .life_counter(3'b101),
      .cycle, .latch, .frame_done, .frame_status, .line_delay, .word_done, .word_slave(slave), .word_position(position),
      .word_n_error(n_error), .word_n_warning(n_warning), .word_life(life), .word_crc_ok(crc_ok),
      .register_start(start), .register_write(write), .register_id(id), .register_address(address),
      .register_wdata(wdata), .register_more(more), .register_busy(busy), .register_done(done), .register_rdata(rdata),
      .register_status(status), .ma, .sl);

  always #5 clk = !clk;

  int checks, errors, line;

  task automatic check(bit right, string what);
    checks++;
    if (!right) begin
      errors++;
      if (errors < 20) $display("%0d us, line %0d: %s", $time / 1000, line, what);
    end
  endtask

  // ---------------------------------------------------------------- wire
  int delay_ns, busy_kind;
  logic [3:0] slo;
  logic far_ma = 1, near_sl = 0;
  logic stuck = 0, stuck_at = 0, flip = 0;

  always @(ma) far_ma <= #(delay_ns) ma;
  always @(slo[busy_kind]) near_sl <= #(delay_ns) slo[busy_kind];
  assign sl = stuck ? stuck_at : near_sl ^ flip;

`define FAST " eeprom_read_us=50 eeprom_write_us=100"
  biss_chain #(.SETTINGS({"busy_us=0", `FAST})) chain0 (.ma(far_ma || busy_kind != 0), .count, .slo(slo[0]));
  biss_chain #(.SETTINGS({"busy_us=3", `FAST})) chain1 (.ma(far_ma || busy_kind != 1), .count, .slo(slo[1]));
  biss_chain #(.SETTINGS({"busy_us=5.5", `FAST})) chain2 (.ma(far_ma || busy_kind != 2), .count, .slo(slo[2]));
  biss_chain #(.SETTINGS({"busy_us=20", `FAST})) chain3 (.ma(far_ma || busy_kind != 3), .count, .slo(slo[3]));

  // What goes wrong with it, so many clocks behind an event: now, Ack or the start bit of the next frame.
  typedef enum {NEVER, AT_ACK, AT_START, COUNT, FLIPPED} damage_t;
  damage_t damage = NEVER;
  int damage_clocks;
  bit damage_flips;
  logic sl_before = 0;

  always @(negedge clk) begin
    case (damage)
      AT_ACK: if (sl_before && !sl) damage <= damage_flips ? AT_START : COUNT;
      AT_START: if (!sl_before && sl) damage <= COUNT;
      COUNT: begin
        damage_clocks <= damage_clocks - 1;
        if (damage_clocks <= 0) begin
          flip <= damage_flips;
          stuck <= !damage_flips;
          damage <= damage_flips ? FLIPPED : NEVER;
          damage_clocks <= 2 * int'(half);
        end
      end
      FLIPPED: begin
        damage_clocks <= damage_clocks - 1;
        if (damage_clocks <= 0) begin
          flip <= 0;
          damage <= NEVER;
        end
      end
      default: ;
    endcase
    sl_before <= sl;
  end

  // ---------------------------------------------------------------- what is expected of a word
  longint angle[3];  // in 2^-24 turns
  longint rate[3];   // in 2^-24 turns per second, from `since` on
  longint since;     // ns, as all moments
  longint latched;   // e1 at the encoders
  longint ack, started;
  int life_[3] = '{0, 0, 0};
  bit judged = 1;    // words are to be right
  bit n_error_ = 1, n_warning_ = 1;
  longint offset = 0;  // of the first one
  int words;

  // Counts of the angle, rounded down, less the offset, modulo the width.
  function automatic longint expected(int slot);
    longint turned = angle[slot];
    turned += longint'($floor(real'(rate[slot]) * real'(latched - since) / 1e9));
    return ((turned >>> (24 - ST[slot])) - (slot == 0 ? offset : 0)) & ((64'd1 << (MT[slot] + ST[slot])) - 1);
  endfunction

  always @(posedge latch) begin
    latched = $time + longint'(delay_ns);
    ack = 0;
    started = 0;
  end
  always @(negedge near_sl) if (ack == 0) ack = $time;
  always @(posedge near_sl) if (ack != 0 && started == 0) started = $time;

  // From Ack, two flip-flops later; from e1 at the encoder to the start bit, which each of a chain makes later.
  task automatic check_times();
    int period = 20 * int'(half), there = int'(started - latched) - delay_ns, least = BUSY_NS[busy_kind];
    int clks = (2 * delay_ns + 10) / 10;
    check(line_delay >= clks + 1 && line_delay <= clks + 4, $sformatf("line delay %0d clk", line_delay));
    check(there >= least && there <= (least > 2 * period ? least : 2 * period) + (int'(count) + 1) * period + 60,
          $sformatf("start bit %0d ns behind e1", there));
  endtask

  always @(negedge clk) begin
    if (word_done && judged) begin
      automatic longint off = longint'(position) - expected(words);
      check(slave == words, "the order of the chain");
      check(crc_ok, "CRC");
      // A shaft that turns is known to a nanosecond: at 3000 rpm a count of 24 bit is 1.2 ns.
      check(rate[words] == 0 ? off == 0 : off >= -1 && off <= 1, $sformatf(
            "slave %0d: position %h, not %h", words, position, expected(words)));
      check(n_error == n_error_ && n_warning == n_warning_, $sformatf(
            "slave %0d: nERR %b nWARN %b", words, n_error, n_warning));
      check(life == (LC[words] ? life_[words] : 0), $sformatf("slave %0d: LC %0d, not %0d", words, life, life_[words]));
    end
    if (word_done) begin
      if (!judged) life_[slave] = int'(life);  // one that failed may have counted, or not
      life_[slave] = life_[slave] == 63 ? 1 : life_[slave] + 1;
      words++;
    end
    if (frame_done) begin
      if (judged) begin
        check(frame_status == 0, $sformatf("frame status %0d", frame_status));
        check(words == count, $sformatf("%0d words", words));
        if (frame_status == 0) check_times();
      end
      words = 0;
    end
  end

  // ---------------------------------------------------------------- what a script does
  task automatic move(int slot, longint to, longint by);
    real turns = real'(to) / 16777216.0, rpm = real'(by) / 16777216.0 * 60.0;
    angle[slot] = to;
    rate[slot] = by;
    since = $time;
    case (busy_kind)
      0: chain0.move(slot, turns, rpm);
      1: chain1.move(slot, turns, rpm);
      2: chain2.move(slot, turns, rpm);
      default: chain3.move(slot, turns, rpm);
    endcase
  endtask

  string script, op, text;
  int file, trace = 0, seed = 1, a, b, c, d, todo, want, data;
  bit random, spin, any, all_crc_ok;

  // Tasks are inlined by Verilator: each that waits is called in one place.
  initial begin
    half = 5;
    delay_ns = 20;
    busy_kind = 1;
    count = 1;
    if ($value$plusargs("half=%d", a)) half = 12'(a);
    if ($value$plusargs("delay=%d", a)) delay_ns = a;
    if ($value$plusargs("busy=%d", a)) busy_kind = a;
    if ($value$plusargs("chain=%d", a)) count = 4'(a);
    if ($value$plusargs("seed=%d", a)) seed = a;
    if ($value$plusargs("trace=%s", text)) trace = $fopen(text, "w");
    void'($urandom(seed));
    void'($value$plusargs("script=%s", script));
    file = $fopen(script, "r");
    if (file == 0) $fatal(1, "no script");
    #20; // power comes after 1 ns, and the line follows after 10
    check(slo[busy_kind] === 0, "SLO is not low before the first pulse");
    repeat (20) @(negedge clk);
    reset = 0;
    while ($fscanf(file, "%s %s %d %d %d %d", op, text, a, b, c, d) == 6) begin
      line++;
      todo = 0;  // frames
      want = 0;
      {random, spin, any} = 0;
      case (op)
        "frame": todo = a;
        "random": {todo, random} = {a, 1'b1};
        "spin": {todo, random, spin} = {a, 2'b11};
        "broken": {todo, want, any} = {32'd1, a, 1'b1};  // one that fails, and how
        "expect": {n_error_, n_warning_, judged} = {1'(a), 1'(b), 1'(c)};
        "offset": offset = longint'(a);
        "fault": chain1.first.fault(text, 1'(a));
        "world": chain1.first.world(text, real'(a));
        "power": begin
          chain1.first.power(1'(a));
          life_[0] = 0;
        end
        "sl": check(sl === 1'(a), "level of SL");
        "wait": repeat (a) #1us;
        "damage": begin  // A: damage_t, B: clocks, C: flips a bit, D: level of one that sticks
          damage_clocks = b;
          damage_flips = 1'(c);
          stuck_at = 1'(d);
          damage = damage_t'(a);
        end
        "mend": {stuck, flip} = 0;
        "read", "write", "read_on", "write_on": ;
        default: check(0, {"no such command: ", op});
      endcase

      all_crc_ok = 1;
      repeat (todo) begin
        if (random)
          for (int i = 0; i < 3; i++)  // +-4096 turns, up to 3000 rpm
            move(i, (longint'($urandom()) << 5) - (longint'(1) << 36),
                 spin ? (($urandom() & 1) == 1 ? 1 : -1) * 50 * 16777216 * longint'(i + 1) / 3 : 0);
        @(negedge clk) cycle = 1;
        while (!frame_done) begin
          @(negedge clk);
          if (word_done && !crc_ok) all_crc_ok = 0;
        end
        cycle = 0;
        if (any) check(frame_status == 3'(want), $sformatf("frame status %0d", frame_status));
        if (any) check(all_crc_ok == (text != "crc"), "CRC");
        @(negedge clk);
      end

      // ID, address, what is or was there (-1: told, not judged), status; _ON: C registers from there on.
      if (op == "read" || op == "write" || op == "read_on" || op == "write_on") begin
        todo = op == "read_on" || op == "write_on" ? c : 1;
        write = op == "write" || op == "write_on";
        {id, address} = {3'(a), 7'(b)};
        wdata = todo == 1 ? 8'(c) : 8'(b * 7 + 1);
        cycle = 1;
        start = 1;
        @(negedge clk) start = 0;
        for (int i = 0; i < todo; i++) begin
          wdata = 8'((b + i + 1) * 7 + 1);
          more = i < todo - 1;
          while (!done) @(negedge clk);
          data = todo == 1 ? c : write ? int'(8'((b + i) * 7 + 1)) : -1;
          check(int'(status) == (i == todo - 1 ? d : 0), $sformatf("%s %s ID %0d %h: status %0d", op, text, a, b + i, status));
          if (status == 0 && data >= 0)
            check(rdata == 8'(data), $sformatf("%s %s ID %0d %h: %h, not %h", op, text, a, b + i, rdata, data));
          if (data < 0) $display("%s %0d %0d %0d %0d", text, a, b + i, rdata, status);
          if (status != 0) break;
          @(negedge clk);
        end
        more = 0;
        while (!frame_done) @(negedge clk);
        cycle = 0;
        @(negedge clk);
      end
    end
    if (line == 0) check(0, "an empty script");
    if (errors != 0) $display("%0d of %0d checks failed", errors, checks);
    else $display("passed %0d checks in %0d us", checks, $time / 1000);
    $finish;
  end

  initial begin
    repeat (40000) #100us;
    $display("no end");
    $finish;
  end

  // ---------------------------------------------------------------- for the other master to do the same
  int clocks;
  logic [131:0] traced;
  wire [131:0] now_ = {reset, half, count, cycle, start, write, more, id, address, wdata, sl, ma, latch, frame_done,
                       word_done, busy, done, frame_done ? {frame_status, line_delay} : 15'd0,
                       word_done ? {slave, position, n_error, n_warning, crc_ok, life} : 60'd0,
                       done ? {rdata, status} : 11'd0};
  always @(posedge clk)
    if (trace != 0) begin
      if (clocks == 0 || now_ != traced) $fdisplay(trace, "%0d %b", clocks, now_);
      clocks <= clocks + 1;
      traced <= now_;
    end
endmodule
