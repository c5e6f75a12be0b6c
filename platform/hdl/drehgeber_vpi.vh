// SPDX-License-Identifier: MIT
// What all models for VPI share: the loop around the encoder, and the tasks of a test bench. Included by each of them
// inside of its module, which has its inputs as `inputs`, puts `levels` to its outputs and makes the encoder.
  integer id;
  integer levels;
  integer rest;
  integer count; // of moments to look again, ever
  integer again; // the one that has come
  integer asked; // changes, when the test bench has done something
  reg [63:0] due; // of the next moment, in ps; all ones: there is none

  initial begin
    count = 0;
    asked = 0;
    due = ~64'd0;
    #0 asked = 1;
  end

  // An earlier moment than the one that is waited for is waited for as well; the later one then finds nothing to do.
  always @(inputs or again or asked) begin
    make;
    if (due <= $time) due = ~64'd0;
    levels = $drehgeber_look(id, inputs);
    rest = $drehgeber_rest(id);
    if ($time + rest < due) begin
      due = $time + rest;
      count = count + 1;
      again <= #(rest) count;
    end
  end

  task steer(input integer what, input [8*256-1:0] text, input real value);
    begin
      make;
      $drehgeber_steer(id, what, text, value);
      asked = asked + 1;
    end
  endtask

  // The shaft is at so many turns, and rests; turns on with so many revolutions per minute; moves as words say.
  task turn(input real turns);
    steer(0, "", turns);
  endtask
  task speed(input real rpm);
    steer(1, "", rpm);
  endtask
  task motion(input [8*256-1:0] words);
    steer(2, words, 0.0);
  endtask
  // A quantity of its world, in its unit: world("temperature", 125.0).
  task world(input [8*256-1:0] quantity, input real value);
    steer(3, quantity, value);
  endtask
  // A fault happens, or is made good.
  task fault(input [8*256-1:0] which, input on);
    steer(4, which, on ? 1.0 : 0.0);
  endtask
  task power(input on);
    steer(5, "", on ? 1.0 : 0.0);
  endtask
  // A line of SCPI, and what it answers.
  task command(input [8*256-1:0] line, output [8*256-1:0] answer);
    begin
      steer(6, line, 0.0);
      $drehgeber_answer(id, answer);
    end
  endtask

  // What the latest frame has, the moment that is of in us, and what one would have that is latched now.
  task latched(output real counts);
    begin
      make;
      $drehgeber_real(id, 1, counts);
    end
  endtask
  task latched_at_us(output real us);
    begin
      make;
      $drehgeber_real(id, 2, us);
    end
  endtask
  task position(output real counts);
    begin
      make;
      $drehgeber_real(id, 0, counts);
    end
  endtask
