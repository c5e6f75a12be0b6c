// SPDX-License-Identifier: MIT
// An SSI master: position, error bit and parity of one encoder, or its word as it came.
//
//  clock ~~\_/~~\__/~~\__/ ... ~\__/~~~~~~~~~~~~~~~~
//          f1    f2               fn+1
//  data  ~~~~|MSB  |     |  ... |LSB  |____________/~~
//          ^ the position is that of f1   pause
//
// Data moves on rising edges. Nothing in SSI says how long the line is: `sample_delay` does, from a
// rising edge of clock to the look at data; it may be longer than a period, clock goes on meanwhile.
// There is one clock more than the word has bits, and behind the word a 0: a 1 there is a word of
// another length, or an encoder that does not answer. Data that is 0 at rest is a wire that is
// broken or an encoder without power, or one that has not started yet.
`default_nettype none

module ssi_master #(
    parameter CLK_HZ = 100000000,  // frequency of clk, at most 500 MHz
    parameter WORD_MAX = 34        // most bits of a word, 2..63
) (
    input wire clk,
    input wire reset,  // synchronous

    // Settings. To be changed while `cycle` is 0 and the last word is done, or never.
    input wire [11:0] clock_half,     // half a period of clock in clk, 2..4095: CLK_HZ / (2 * f)
    input wire [11:0] sample_delay,   // from a rising edge to the look in clk, 3..4095: line both
                                      // ways, encoder and two flip-flops, and half a period, say
    input wire [7:0] pause_us,        // from the last edge to the next word, above the monoflop time
    input wire [5:0] position_bits,   // multiturn and singleturn, 1..WORD_MAX
    input wire gray,                  // 1: the position is in Gray code
    input wire has_error,             // 1: an error bit follows
    input wire has_parity,            // 1: a parity bit follows, over all bits before it
    input wire parity_odd,            // 1: it makes the number of ones odd, 0: even

    // Words
    input wire cycle,                 // 1: begin a word, and the next one when this is done
    output reg latch,                 // one clk: f1 leaves; the position will be that of now
    output reg done,                  // one clk: a word is over, all of what follows is valid
    output reg [1:0] status,          // STATUS_..., below
    output reg [WORD_MAX-1:0] word,   // as it came, right-aligned
    output reg [WORD_MAX-1:0] position,  // binary, right-aligned
    output reg error,                 // the error bit, whichever level means one; 0 without one
    output reg parity_ok,             // 1 without a parity bit

    // Wire
    output reg clock,
    input wire data  // asynchronous
);
  // status
  localparam STATUS_OK = 2'd0;
  localparam STATUS_NOT_READY = 2'd1;  // data was 0 at rest: nothing was clocked
  localparam STATUS_NO_STOP = 2'd2;    // data was 1 behind the word
  localparam STATUS_NO_PAUSE = 2'd3;   // data is 0 after the pause: it was too short, or the line broke

  localparam [1:0] IDLE = 0, CLOCK = 1, DRAIN = 2, PAUSE = 3;

  // An edge before reset would be one to the encoder, too.
  initial clock = 1;

  // ---------------------------------------------------------------- data, and time
  reg data_0, data_1;  // data_1 is safe

  always @(posedge clk) begin
    data_0 <= data;
    data_1 <= data_0;
  end

  localparam [31:0] CLKS_A_US = (CLK_HZ + 999999) / 1000000;
  reg [8:0] tick_left;
  reg us;  // one clk in a microsecond

  always @(posedge clk) begin
    us <= tick_left == 0;
    tick_left <= reset || tick_left == 0 ? CLKS_A_US[8:0] - 9'd1 : tick_left - 9'd1;
  end

  // ---------------------------------------------------------------- clock
  reg [1:0] state;
  reg [11:0] half_left;
  reg half_end;
  reg [5:0] clocks_left;
  reg [7:0] waited_us;
  reg pause_over;
  reg listening;  // data is looked at, from the first rising edge to the bit behind the word

  wire [5:0] word_bits = position_bits + {5'd0, has_error} + {5'd0, has_parity};
  wire first_rise = state == CLOCK && half_end && !clock && clocks_left == word_bits;
  wire stop;  // the bit behind the word is looked at

  always @(posedge clk) begin
    latch <= 0;
    done <= 0;
    half_left <= half_left - 12'd1;
    half_end <= half_left == 1 && state == CLOCK;
    if (us && waited_us != 8'hFF) waited_us <= waited_us + 8'd1;
    pause_over <= waited_us > pause_us;
    case (state)
      IDLE:
      if (cycle) begin
        half_left <= clock_half - 12'd1;
        clocks_left <= word_bits;
        waited_us <= 0;
        pause_over <= 0;
        status <= data_1 ? STATUS_OK : STATUS_NOT_READY;
        state <= data_1 ? CLOCK : PAUSE;
        clock <= !data_1;
        latch <= data_1;
      end
      CLOCK:
      if (half_end) begin
        half_left <= clock_half - 12'd1;
        clock <= !clock;
        if (!clock) begin
          clocks_left <= clocks_left - 6'd1;
          if (clocks_left == 0) state <= DRAIN;
        end
      end
      DRAIN: begin
        waited_us <= 0;
        pause_over <= 0;
        if (!listening) state <= PAUSE;
      end
      default:  // PAUSE
      if (pause_over) begin
        state <= IDLE;
        done <= 1;
        if (status == STATUS_OK && !data_1) status <= STATUS_NO_PAUSE;
      end
    endcase
    if (stop && data_1) status <= STATUS_NO_STOP;
    if (reset) begin
      state <= PAUSE;
      clock <= 1;
      done <= 0;
      waited_us <= 0;
      pause_over <= 0;
      status <= STATUS_NOT_READY;
    end
  end

  // ---------------------------------------------------------------- receiver
  reg [12:0] sample_left;
  reg sample;
  reg [5:0] position_left;
  reg error_left;
  reg parity_left;
  reg parity;  // of all bits so far
  reg binary;  // the last one of the position, decoded

  wire next_binary = data_1 ^ (gray && binary);

  assign stop = listening && sample && position_left == 0 && !error_left && !parity_left;

  always @(posedge clk) begin
    sample <= listening && sample_left == 0;
    sample_left <= sample_left == 0 ? {clock_half, 1'b0} - 13'd1 : sample_left - 13'd1;
    if (first_rise) begin
      listening <= 1;
      sample <= 0;
      sample_left <= {1'b0, sample_delay} - 13'd2;
      position_left <= position_bits;
      error_left <= has_error;
      parity_left <= has_parity;
      word <= 0;
      position <= 0;
      error <= 0;
      parity <= 0;
      binary <= 0;
    end else if (listening && sample) begin
      if (!stop) begin
        word <= {word[WORD_MAX-2:0], data_1};
        parity <= parity ^ data_1;
      end
      if (position_left != 0) begin
        position <= {position[WORD_MAX-2:0], next_binary};
        binary <= next_binary;
        position_left <= position_left - 6'd1;
      end else if (error_left) begin
        error <= data_1;
        error_left <= 0;
      end else if (parity_left) begin
        parity_left <= 0;
      end else begin
        listening <= 0;
        parity_ok <= !has_parity || parity == parity_odd;
      end
    end
    if (reset) listening <= 0;
  end
endmodule

`default_nettype wire
