// SPDX-License-Identifier: MIT
// What all models for DPI-C share: the loop around the encoder, and the tasks of a test bench. Included by each of
// them inside of its module, which has settings(), inputs() and outputs().
  // Delays of what Verilator 5.006 inlines are in the unit of the module above, which may be nanoseconds.
  /* verilator no_inline_module */
  import "DPI-C" function chandle dg_hdl_open(input string model, input string settings, input string motion,
                                              input string memory);
  import "DPI-C" function void dg_hdl_close(input chandle self);
  import "DPI-C" function string dg_hdl_error(input chandle self);
  import "DPI-C" function int dg_hdl_wires(input chandle self, input longint now, input int levels);
  import "DPI-C" function longint dg_hdl_next(input chandle self);
  import "DPI-C" function string dg_hdl_hint(input chandle self, input int at_end);
  import "DPI-C" function longint dg_hdl_latched(input chandle self);
  import "DPI-C" function longint dg_hdl_latched_at(input chandle self);
  import "DPI-C" function longint dg_hdl_position(input chandle self, input longint at);
  import "DPI-C" function int dg_hdl_turn(input chandle self, input longint now, input real turns);
  import "DPI-C" function int dg_hdl_speed(input chandle self, input longint now, input real rpm);
  import "DPI-C" function int dg_hdl_motion(input chandle self, input longint now, input string words);
  import "DPI-C" function int dg_hdl_world(input chandle self, input longint now, input string name, input real value);
  import "DPI-C" function int dg_hdl_fault(input chandle self, input longint now, input string name, input int on);
  import "DPI-C" function int dg_hdl_power(input chandle self, input longint now, input int on);
  import "DPI-C" function string dg_hdl_command(input chandle self, input longint now, input string line);
  import "DPI-C" function real dg_hdl_volts(input chandle self, input longint at, input int index);

  localparam longint NEVER = 64'sh7FFF_FFFF_FFFF_FFFF;
  chandle encoder;
  // Moments at which to look again, the earliest one first: none is put behind another.
  longint wakes[$];
  longint earliest = NEVER; // of them: the queue itself is looked at when one comes or goes
  int     count; // of them ever
  int     again; // the one that has come
  int     asked; // changes, when the test bench has done something

  function automatic longint now_ps();
    return longint'($time);
  endfunction

  // Whatever is called first makes the encoder.
  function automatic void make();
    if (encoder == null) begin
      encoder = dg_hdl_open(MODEL, settings(), MOTION, MEMORY);
      if (encoder == null) $fatal(1, "%m: no memory for an encoder");
      else if (dg_hdl_error(encoder) != "") $fatal(1, "%m: %s", dg_hdl_error(encoder));
    end
  endfunction

  function automatic void check(int result);
    if (result < 0) $fatal(1, "%m: %s", dg_hdl_error(encoder));
  endfunction

  // Levels in, levels out, and when to do that again unless an input changes before: to be called by an always
  // block and by nothing else.
  task automatic look();
    longint due;
    longint now;
    int     levels;
    make();
    now = now_ps();
    while (earliest <= now) begin
      void'(wakes.pop_front());
      earliest = wakes.size() != 0 ? wakes[0] : NEVER;
    end
    levels = dg_hdl_wires(encoder, now, inputs());
    outputs(levels);
    if (levels[8]) hint(0);
    due = dg_hdl_next(encoder);
    if (due >= 0 && due < earliest) begin
      wakes.push_front(due);
      earliest = due;
      count++;
      again <= #(due - now) count;
    end
  endtask

  // What the encoder has to tell the user.
  function automatic void hint(int at_end);
    string text = dg_hdl_hint(encoder, at_end);
    if (text != "") $display("%m: %s", text);
  endfunction

  initial asked++;
  final begin
    hint(1);
    dg_hdl_close(encoder);
  end

  // The shaft is at so many turns, and rests.
  task automatic turn(real turns);
    make();
    check(dg_hdl_turn(encoder, now_ps(), turns));
    asked++;
  endtask

  // It turns on with so many revolutions per minute.
  task automatic speed(real rpm);
    make();
    check(dg_hdl_speed(encoder, now_ps(), rpm));
    asked++;
  endtask

  // It moves as these words say, which are those of the parameter MOTION.
  task automatic motion(string words);
    make();
    check(dg_hdl_motion(encoder, now_ps(), words));
    asked++;
  endtask

  // A quantity of its world: world("temperature", 125.0).
  task automatic world(string name, real value);
    make();
    check(dg_hdl_world(encoder, now_ps(), name, value));
    asked++;
  endtask

  // A fault happens, or is made good: drehgeber faults MODEL.
  task automatic fault(string name, bit on = 1'b1);
    make();
    check(dg_hdl_fault(encoder, now_ps(), name, int'(on)));
    asked++;
  endtask

  task automatic power(bit on);
    make();
    check(dg_hdl_power(encoder, now_ps(), int'(on)));
    asked++;
  endtask

  // A line of SCPI, and what it answers.
  task automatic command(string line, output string answer);
    make();
    answer = dg_hdl_command(encoder, now_ps(), line);
    if (dg_hdl_error(encoder) != "") $fatal(1, "%m: %s", dg_hdl_error(encoder));
    asked++;
  endtask

  // What the latest frame has, the moment that is of in ps, and what one would have that is latched now.
  function automatic longint latched();
    make();
    return dg_hdl_latched(encoder);
  endfunction

  function automatic longint latched_at();
    make();
    return dg_hdl_latched_at(encoder);
  endfunction

  function automatic longint position();
    make();
    return dg_hdl_position(encoder, now_ps());
  endfunction

  // The same of any moment in ps.
  function automatic longint position_at(longint at);
    make();
    return dg_hdl_position(encoder, at);
  endfunction
