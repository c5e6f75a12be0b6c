// SPDX-License-Identifier: MIT
// A BiSS-C master: position, errors and registers of up to SLAVES encoders in a chain.
//
//        e1    e2    e3                           last  stop      timeout
//  ma ~\_/~~\__/~~\__/~~\__/ ... ~~\__/~~\__/~~\__/~~\__/~~~~ CDM = 0 ~~~~
//                                                       \____ CDM = 1 ____/
//  sl ~~~~~~~~\_Ack ..._/Start\CDS X data ... X nERR X nWARN X LC X CRC\______/~
//
// The position is that of e1. The encoder answers at rising edges of ma; line and drivers delay
// that, by more than a period at will. So sl is not sampled by ma: Ack, the falling edge of sl
// behind e2, says where its bits begin, in each frame anew, and each is taken in its middle. Until
// the last one has come ma goes on; clocks beyond the CRC shift nothing.
//
// From the power-on of an encoder sl may be low until e1: a frame starts without a look at sl.
// What the encoder ends a frame with is that it sets sl again: that is waited for.
//
// Registers go along with frames, a bit in each: ma during the timeout (CDM) and the bit behind the
// start bit (CDS). An access is 33 frames for the first register and 14 for each that follows.
// It needs frames: hold `cycle` at 1.
`default_nettype none

module biss_master #(
    parameter CLK_HZ = 100000000,  // frequency of clk, at most 500 MHz
    parameter SLAVES = 1,          // most encoders in the chain, 1..8
    parameter POSITION_MAX = 48,   // most bits of a position, multiturn and singleturn, 12..63
    parameter BUSY_US = 40         // longest processing time, from Ack on, at most 250; e1 to Ack as long
) (
    input wire clk,
    input wire reset,  // synchronous; a bus reset of 40 us follows

    // Settings. To be changed while `cycle` is 0 and the last frame is done, or never.
    input wire [11:0] ma_half,                // half a period of ma in clk, 2..4095: CLK_HZ / (2 * f)
    input wire [3:0] slave_count,             // encoders in the chain, 1..SLAVES
    input wire [6*SLAVES-1:0] position_bits,  // of each; the one nearest to the master in bits 5..0
    input wire [SLAVES-1:0] life_counter,     // 1: its frame has the six bits LC

    // Frames
    input wire cycle,                // 1: begin a frame, and the next one when this is done
    output reg latch,                // one clk: e1 leaves; the position will be that of now
    output reg frame_done,           // one clk: a frame is over, frame_status is valid
    output reg [2:0] frame_status,   // FRAME_..., below
    output reg [11:0] line_delay,    // from e2 to Ack in clk: line both ways, encoder, two flip-flops

    // What an encoder said; valid with word_done until the next one
    output reg word_done,                         // one clk
    output reg [2:0] word_slave,                  // which one, 0 is nearest to the master
    output reg [POSITION_MAX-1:0] word_position,  // multiturn and singleturn, right-aligned
    output reg word_n_error,                      // 0 is an error
    output reg word_n_warning,                    // 0 is a warning
    output reg [5:0] word_life,                   // life counter; 0 without one
    output reg word_crc_ok,                       // the check sum fits: use the rest only then

    // Registers
    input wire register_start,          // one clk, while register_busy is 0: begin an access
    input wire register_write,          // 1: write, 0: read       taken with register_start
    input wire [2:0] register_id,       // of the encoder          "
    input wire [6:0] register_address,  // of the first register   "
    input wire [7:0] register_wdata,    // to write                ", and with each register_done
    input wire register_more,           // one more register behind this one: taken with register_done
    output wire register_busy,          // 1 until the last register is done
    output reg register_done,           // one clk: a register is done, the next two are valid
    output reg [7:0] register_rdata,    // read, or the echo of what was written
    output reg [2:0] register_status,   // REGISTER_..., below; an access ends with any but OK

    // Wire
    output reg ma,
    input wire sl  // asynchronous
);
  // frame_status
  localparam FRAME_OK = 3'd0;
  localparam FRAME_NO_ACK = 3'd1;      // sl did not fall behind e2
  localparam FRAME_NO_START = 3'd2;    // no start bit within BUSY_US
  localparam FRAME_NO_STOP = 3'd3;     // sl is high behind the last bit: another length, or stuck
  localparam FRAME_NO_TIMEOUT = 3'd4;  // sl is still low after 40 us

  // register_status
  localparam REGISTER_OK = 3'd0;
  localparam REGISTER_REFUSED = 3'd1;    // the encoder does not have it, or does not permit this
  localparam REGISTER_CHECK = 3'd2;      // CRC of what was read, or echo of what was written, is wrong
  localparam REGISTER_LATE = 3'd3;       // the encoder is busy for more than 20 ms
  localparam REGISTER_NO_ANSWER = 3'd4;  // nobody has this ID, or the address was not understood
  localparam REGISTER_LINE = 3'd5;       // a frame failed meanwhile

  localparam BUS_RESET_US = 40;
  localparam BUSY_R_US = 20000;
  localparam ZEROS = 14;

  localparam [2:0] PAUSE = 0, IDLE = 1, CLOCK = 2, TIMEOUT = 3, RETURN = 4;
  localparam [2:0] R_OFF = 0, R_ACK = 1, R_START = 2, R_CDS = 3, R_DATA = 4, R_CRC = 5, R_STOP = 6;

  // An edge before reset would be one to the encoder, too.
  initial ma = 1;

  // ---------------------------------------------------------------- sl, and time
  reg sl_0, sl_1, sl_2;  // sl_1 is safe, sl_2 is sl_1 of one clk ago

  always @(posedge clk) begin
    sl_0 <= sl;
    sl_1 <= sl_0;
    sl_2 <= sl_1;
  end

  localparam [31:0] CLKS_A_US = (CLK_HZ + 999999) / 1000000;
  reg [8:0] tick_left;
  reg us;  // one clk in a microsecond

  always @(posedge clk) begin
    us <= tick_left == 0;
    tick_left <= reset || tick_left == 0 ? CLKS_A_US[8:0] - 9'd1 : tick_left - 9'd1;
  end

  // ---------------------------------------------------------------- frame
  reg [2:0] state;
  reg [2:0] receiver;
  reg [11:0] half_left;    // of the half period of ma
  reg half_end;            // this is its last clk
  reg [12:0] sample_left;  // to the middle of the next bit of sl
  reg sample;              // it is here
  reg [3:0] clocks;        // rising edges since the start of the frame, or Ack; 15 are many
  reg over;                // the last clock is the one that runs
  reg [11:0] delay;        // since e2

  wire ack = receiver == R_ACK && clocks >= 2 && sl_2 && !sl_1;
  // At a slow clock BUSY_US are few clocks, and each encoder of a chain takes one for itself.
  wire too_late = busy_over && clocks == 15;
  wire no_ack = receiver == R_ACK && too_late;
  wire no_start = receiver == R_START && sample && !sl_1 && too_late;
  wire no_stop = receiver == R_STOP && sample && sl_1;
  wire no_timeout = state == TIMEOUT && !sl_1 && pause_over;
  wire failed = no_ack || no_start || no_stop || no_timeout;
  wire whole = receiver == R_STOP && sample && !sl_1;  // the frame is here, CDM is to be chosen

  wire last_edge = state == CLOCK && half_end && ma && over;

  // Since the start of the frame, Ack, the last edge, or the begin of a pause.
  reg [7:0] waited_us;
  reg busy_over;
  reg pause_over;

  always @(posedge clk)
    if (reset || state == IDLE || ack || last_edge || no_timeout) begin
      waited_us <= 0;
      busy_over <= 0;
      pause_over <= 0;
    end else begin
      if (us && waited_us != 8'hFF) waited_us <= waited_us + 8'd1;
      busy_over <= waited_us > BUSY_US;
      pause_over <= waited_us > BUS_RESET_US;
    end

  reg cdm;

  always @(posedge clk) begin
    latch <= 0;
    frame_done <= 0;
    half_left <= half_left - 12'd1;
    half_end <= half_left == 1 && (state == CLOCK || state == RETURN);
    case (state)
      PAUSE: begin
        ma <= 1;
        if (pause_over) state <= IDLE;
      end
      IDLE:
      if (cycle) begin
        state <= CLOCK;
        ma <= 0;
        half_left <= ma_half - 12'd1;
        clocks <= 0;
        over <= 0;
      end
      CLOCK:
      if (half_end) begin
        half_left <= ma_half - 12'd1;
        ma <= !ma;
        if (!ma) begin
          latch <= clocks == 0 && receiver == R_ACK;
          if (clocks != 15) clocks <= clocks + 4'd1;
        end else if (over) begin
          ma <= frame_status != FRAME_OK || !cdm;
          state <= frame_status == FRAME_OK ? TIMEOUT : PAUSE;
          frame_done <= frame_status != FRAME_OK;
        end
      end
      TIMEOUT:
      if (sl_1) begin
        ma <= 1;
        half_left <= ma_half - 12'd1;
        state <= RETURN;
      end else if (no_timeout) begin
        frame_done <= 1;
        state <= PAUSE;
      end
      default:  // RETURN: ma is high for half a period at least
      if (half_end) begin
        frame_done <= 1;
        state <= IDLE;
      end
    endcase
    if (ack) clocks <= 0;
    if (whole || failed) over <= 1;
    if (state == IDLE) frame_status <= FRAME_OK;
    else if (no_ack) frame_status <= FRAME_NO_ACK;
    else if (no_start) frame_status <= FRAME_NO_START;
    else if (no_stop) frame_status <= FRAME_NO_STOP;
    else if (no_timeout) frame_status <= FRAME_NO_TIMEOUT;
    if (reset) begin
      state <= PAUSE;
      ma <= 1;
      frame_status <= FRAME_OK;
    end
  end

  // ---------------------------------------------------------------- receiver
  // x^6 + x + 1, over everything behind CDS; it comes inverted: with it, inverted, the rest is 0.
  function [5:0] crc6_next(input [5:0] crc, input data);
    crc6_next = {crc[4:0], 1'b0} ^ (crc[5] ^ data ? 6'h03 : 6'h00);
  endfunction

  reg [POSITION_MAX+7:0] word;     // position, nERR, nWARN, LC
  reg [5:0] crc6;
  reg [6:0] bits_left;
  reg [3:0] slaves_left;
  reg [2:0] slave;
  reg [6*SLAVES-1:0] positions;    // of the encoders that are still to come
  reg [SLAVES-1:0] life_counters;  // "
  reg cds;

  wire [5:0] crc6_with = crc6_next(crc6, sl_1 ^ (receiver == R_CRC));
  wire [6:0] data_bits = {1'b0, positions[5:0]} + (life_counters[0] ? 7'd8 : 7'd2);
  reg with_life;
  wire ready = sample && (receiver == R_CDS || receiver == R_CRC && bits_left == 1);

  always @(posedge clk) begin
    word_done <= 0;
    delay <= clocks < 2 ? 12'd0 : delay == 12'hFFF ? delay : delay + 12'd1;
    sample <= sample_left == 0 && receiver != R_ACK;
    sample_left <= sample_left == 0 ? {ma_half, 1'b0} - 13'd1 : sample_left - 13'd1;
    case (receiver)
      R_OFF:
      if (state == IDLE && cycle) begin
        receiver <= R_ACK;
        positions <= position_bits;
        life_counters <= life_counter;
        slaves_left <= slave_count;
        slave <= 0;
      end
      R_ACK:
      if (ack) begin
        receiver <= R_START;
        line_delay <= delay;
        sample_left <= {1'b0, ma_half} - 13'd2;
      end
      R_START: if (sample && sl_1) receiver <= R_CDS;
      R_CDS:
      if (sample) begin
        cds <= sl_1;
        receiver <= R_DATA;
      end
      R_DATA:
      if (sample) begin
        word <= {word[POSITION_MAX+6:0], sl_1};
        crc6 <= crc6_with;
        bits_left <= bits_left - 7'd1;
        if (bits_left == 1) begin
          receiver <= R_CRC;
          bits_left <= 6;
        end
      end
      R_CRC:
      if (sample) begin
        crc6 <= crc6_with;
        bits_left <= bits_left - 7'd1;
        if (bits_left == 1) begin
          word_done <= 1;
          word_slave <= slave;
          word_position <= with_life ? word[POSITION_MAX+7:8] : word[POSITION_MAX+1:2];
          {word_n_error, word_n_warning} <= with_life ? word[7:6] : word[1:0];
          word_life <= with_life ? word[5:0] : 6'd0;
          word_crc_ok <= crc6_with == 0;
          slave <= slave + 3'd1;
          slaves_left <= slaves_left - 4'd1;
          receiver <= slaves_left == 1 ? R_STOP : R_DATA;
        end
      end
      default: if (sample) receiver <= R_OFF;  // R_STOP
    endcase
    if (ready) begin  // for the data of the next encoder
      word <= 0;
      crc6 <= 0;
      bits_left <= data_bits;
      with_life <= life_counters[0];
      positions <= positions >> 6;
      life_counters <= life_counters >> 1;
    end
    if (failed || reset) receiver <= R_OFF;
  end

  // ---------------------------------------------------------------- registers
  // step, the CDM of which frame is next:
  //   0 S   1 CTS   2..4 ID   5..11 ADR   12..15 ~CRC4   16 R   17 W   18 S   19..26 data
  //   27..30 ~CRC4   31 P   32 nothing, or S of one more
  // CDS answers the CDM of the frame before. S that is not echoed in 19 is sent again: busy.
  // x^4 + x + 1, inverted, over CTS, ID, ADR, and over data.
  function [3:0] crc4_next(input [3:0] crc, input data);
    crc4_next = {crc[2:0], 1'b0} ^ (crc[3] ^ data ? 4'h3 : 4'h0);
  endfunction

  reg pending;        // an access waits or runs
  reg write;
  reg [2:0] id;
  reg [3:0] zeros;    // frames with CDM = 0
  reg [5:0] step;
  reg [10:0] sent;    // what goes out, at its left end
  reg [3:0] crc4;
  reg id_there;       // IDL: a slave has this ID
  reg r_echo;
  reg fits;           // all that was written came back
  reg [14:0] start_us;  // since S
  reg late;           // that is too long

  wire [10:0] sent_on = {sent[9:0], 1'b0};
  wire [3:0] crc4_on = {crc4[2:0], 1'b0};
  wire checked = write ? fits : crc4 == 0;

  assign register_busy = pending;

  always @(posedge clk) begin
    register_done <= 0;
    if (us && start_us != 15'h7FFF) start_us <= start_us + 15'd1;
    late <= start_us > BUSY_R_US;
    if (register_start && !pending) begin
      pending <= 1;
      write <= register_write;
      id <= register_id;
      sent <= {1'b1, register_id, register_address};
      register_rdata <= register_wdata;
    end
    if (whole) begin
      cdm <= 0;
      step <= step + 6'd1;
      if (zeros != ZEROS) zeros <= zeros + 4'd1;
      case (step)
        0:
        if (pending && zeros == ZEROS) begin
          cdm <= 1;
          crc4 <= 0;
          id_there <= 0;
        end else step <= 0;
        1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11: begin
          cdm <= sent[10];
          sent <= sent_on;
          crc4 <= crc4_next(crc4, sent[10]);
          if (step == {3'd0, id} + 6'd1) id_there <= cds;
        end
        12, 13, 14, 15: begin
          cdm <= !crc4[3];
          crc4 <= crc4_on;
        end
        16: cdm <= !write;
        17: begin
          cdm <= write;
          r_echo <= cds;
        end
        18:
        if (id_there && r_echo == !write && cds == write) begin
          cdm <= 1;
          sent <= {register_rdata, 3'd0};
          crc4 <= 0;
          fits <= 1;
          start_us <= 0;
        end else begin
          register_status <= id_there && r_echo == !write ? REGISTER_REFUSED : REGISTER_NO_ANSWER;
          register_done <= 1;
          pending <= 0;
          step <= 0;
          zeros <= 0;
        end
        19:
        if (cds) begin
          cdm <= write && sent[10];
          sent <= sent_on;
          if (write) crc4 <= crc4_next(crc4, sent[10]);
        end else if (!late) begin
          cdm <= 1;
          step <= 19;
        end else begin
          register_status <= REGISTER_LATE;
          register_done <= 1;
          pending <= 0;
          step <= 0;
          zeros <= 0;
        end
        20, 21, 22, 23, 24, 25, 26: begin
          cdm <= write && sent[10];
          sent <= sent_on;
          crc4 <= crc4_next(crc4, write ? sent[10] : cds);
          fits <= fits && cds == cdm;
          register_rdata <= {register_rdata[6:0], cds};
        end
        27: begin
          cdm <= write && !crc4[3];
          crc4 <= write ? crc4_on : crc4_next(crc4, cds);
          fits <= fits && cds == cdm;
          register_rdata <= {register_rdata[6:0], cds};
        end
        28, 29, 30: begin
          cdm <= write && !crc4[3];
          crc4 <= write ? crc4_on : crc4_next(crc4, !cds);
          fits <= fits && cds == cdm;
        end
        31: begin
          crc4 <= crc4_next(crc4, !cds);
          fits <= fits && cds == cdm;
        end
        default: begin  // 32: P
          register_status <= !checked ? REGISTER_CHECK : cds ? REGISTER_REFUSED : REGISTER_OK;
          register_done <= 1;
          if (register_more && checked && !cds) begin
            cdm <= 1;
            step <= 19;
            sent <= {register_wdata, 3'd0};
            crc4 <= 0;
            fits <= 1;
            start_us <= 0;
          end else begin
            pending <= 0;
            step <= 0;
            zeros <= 0;
          end
        end
      endcase
    end
    if (failed) begin  // whether the frame ended in a CDM, and in which, is not known
      cdm <= 0;
      zeros <= 0;
      step <= 0;
      if (pending) begin
        register_status <= REGISTER_LINE;
        register_done <= 1;
        pending <= 0;
      end
    end
    if (reset) begin
      pending <= 0;
      cdm <= 0;
      zeros <= 0;
      step <= 0;
    end
  end
endmodule

`default_nettype wire
