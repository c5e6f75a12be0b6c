// SPDX-License-Identifier: MIT
// The SSI master of platform/hdl/master against the encoders of platform/hdl, on one wire, as a script says:
// test_matrix_ssi.py writes it, has the commands, and makes layouts.svh: an encoder for each kind of word.
//
// +script=FILE  lines `COMMAND TEXT A B`              +half=N          half a period of the clock in clocks of 10 ns
// +delay=NS     of the cable, each way, up to 500     +kind=N          which encoder is on the line
// +mt=N +st=N   its bits                              +gray=0|1        the code of its position
// +error=0..2   no bit, high is one, low is one       +parity=0..2     no bit, even, odd
// +seed=N
//
// What is expected is worked out here and in the script, from the angle and from the manual; the model is not asked.
`timescale 1ns / 1ps

module ssi_bench;
  // ---------------------------------------------------------------- master
  logic clk = 0, reset = 1;
  logic [11:0] half, sample_delay;
  logic [7:0] pause = 22;
  logic cycle = 0;
  wire clock, latch, done, error, parity_ok;
  wire [1:0] status;
  wire [33:0] word, position;
  logic data;
  int delay_ns, kind, mt, st, gray, error_kind, parity_kind;

  ssi_master master (
      .clk, .reset, .clock_half(half), .sample_delay, .pause_us(pause), .position_bits(6'(mt + st)), .gray(gray != 0),
      .has_error(error_kind != 0), .has_parity(parity_kind != 0), .parity_odd(parity_kind == 2), .cycle, .latch, .done,
      .status, .word, .position, .error, .parity_ok, .clock, .data);

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
  logic far_clock = 1, near_data = 0, stuck = 0, stuck_at = 0;
  wire data_of_it;

  always @(clock) far_clock <= #(delay_ns) clock;
  always @(data_of_it) near_data <= #(delay_ns) data_of_it;
  assign data = stuck ? stuck_at : near_data;

  // `levels`, `data_of_it`, and steer(what, turns, rpm, text, on), which does it to the encoder on the line.
  `include "layouts.svh"

  // ---------------------------------------------------------------- what is expected of a word
  longint angle, rate;  // in 2^-24 turns; in those per second, from `since` on
  longint since, latched;  // ns
  bit wrong = 0;  // the encoder has an error

  always @(posedge latch) latched = $time + longint'(delay_ns);

  // Counts of the angle, rounded down, modulo the width.
  function automatic longint counts();
    longint turned = angle + longint'($floor(real'(rate) * real'(latched - since) / 1e9));
    longint all = st > 24 ? turned <<< (st - 24) : turned >>> (24 - st);
    return all & ((64'd1 << (mt + st)) - 1);
  endfunction

  // The position in its code, then the error bit, then the parity over all before it.
  function automatic longint expected();
    longint bits = counts();
    if (gray != 0) bits ^= bits >> 1;
    if (error_kind != 0) bits = bits << 1 | longint'(wrong == (error_kind == 1));
    if (parity_kind != 0) bits = bits << 1 | longint'(^bits ^ (parity_kind == 2));
    return bits;
  endfunction

  function automatic int width();
    return mt + st + int'(error_kind != 0) + int'(parity_kind != 0);
  endfunction

  task automatic check_word();
    longint off = longint'(position) - counts(), whole = 64'd1 << (mt + st);
    check(status == 0, $sformatf("status %0d", status));
    check(parity_ok, "parity");
    check(error == (error_kind == 0 ? 0 : wrong == (error_kind == 1)), "error bit");
    if (rate == 0) begin
      check(longint'(word) == expected(), $sformatf("word %h, not %h", word, expected()));
      check(off == 0, $sformatf("position %h, not %h", position, counts()));
    end else
      // A shaft that turns is known to a nanosecond.
      check(off >= -1 && off <= 1 || off == 1 - whole || off == whole - 1, $sformatf(
            "position %h, not %h", position, counts()));
  endtask

  // One that is bent: how, of what it should have been.
  task automatic check_bent(string how);
    longint bent = longint'(word) ^ expected();
    case (how)
      "zero": check(status == 0 && word == 0, $sformatf("word %h is not 0", word));
      "late": begin  // a 1 in front, and the last bit is where there is a 0 behind the word
        check(longint'(word) == (64'd1 << (width() - 1) | expected() >> 1), $sformatf("late: %h of %h", word, expected()));
        check(status == ((expected() & 1) != 0 ? 2 : 0), $sformatf("late: status %0d", status));
      end
      "flip": begin
        check(status == 0 && $countones(bent) == 1, $sformatf("flipped: %h", bent));
        check(!parity_ok, "parity of a flipped bit");
      end
      default: check(0, {"no such way: ", how});
    endcase
  endtask

  // ---------------------------------------------------------------- what a script does
  string script, op, text;
  int file, seed = 1, a, b, todo;
  bit random, spin;

  initial begin
    half = 50;
    if ($value$plusargs("half=%d", a)) half = 12'(a);
    if ($value$plusargs("delay=%d", a)) delay_ns = a;
    if ($value$plusargs("seed=%d", a)) seed = a;
    void'($value$plusargs("kind=%d", kind));
    void'($value$plusargs("mt=%d", mt));
    void'($value$plusargs("st=%d", st));
    void'($value$plusargs("gray=%d", gray));
    void'($value$plusargs("error=%d", error_kind));
    void'($value$plusargs("parity=%d", parity_kind));
    // There and back, the encoder, two flip-flops; half a period behind that.
    sample_delay = 12'((2 * delay_ns + 10) / 10 + 3) + half;
    void'($urandom(seed));
    void'($value$plusargs("script=%s", script));
    file = $fopen(script, "r");
    if (file == 0) $fatal(1, "no script");
    repeat (20) @(negedge clk);
    reset = 0;
    #30us;  // the master begins with a pause
    while ($fscanf(file, "%s %s %d %d", op, text, a, b) == 4) begin
      line++;
      todo = 0;  // words
      {random, spin} = 0;
      case (op)
        "word": todo = a;
        "random": {todo, random} = {a, 1'b1};
        "spin": {todo, random, spin} = {a, 2'b11};
        "broken", "bent": todo = 1;
        "fault": steer(1, 0.0, 0.0, text, 1'(a));
        "power": steer(2, 0.0, 0.0, "", 1'(a));
        "wrong": wrong = 1'(a);
        "pause": pause = 8'(a);
        "stuck": {stuck, stuck_at} = {1'(a), 1'(b)};
        "data": check(data === 1'(a), "level of data");
        "wait": repeat (a) #1us;
        default: check(0, {"no such command: ", op});
      endcase
      repeat (todo) begin
        if (random) begin  // +-2048 turns, up to 3000 rpm
          angle = (longint'($urandom()) << 4) - (longint'(1) << 35);
          rate = spin ? (($urandom() & 1) == 1 ? 1 : -1) * 50 * 16777216 : 0;
          since = $time;
          steer(0, real'(angle) / 16777216.0, real'(rate) / 16777216.0 * 60.0, "", 0);
        end
        @(negedge clk) cycle = 1;
        @(negedge clk);
        while (!done) @(negedge clk);
        cycle = 0;
        if (op == "broken") check(status == 2'(a), $sformatf("status %0d, not %0d", status, a));
        else if (op == "bent") check_bent(text);
        else check_word();
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
endmodule
