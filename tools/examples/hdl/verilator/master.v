// SPDX-License-Identifier: MIT
// A small BiSS-C master, as a user may have one: it reads positions, and checks them. It waits for Ack and start bit
// however long they take, and looks at SLO only behind the first clock, because before that SLO may be low.
//
//   MA   ¯|_|¯|_|¯|_|¯|_|¯|_|¯ ... ¯|_|¯¯¯¯¯¯¯¯¯¯¯   HALF clocks of `clk` each
//   SLO  ??¯¯¯|___|¯|CDS|D D D ... C C|_______|¯¯¯   a bit is taken with the rising edge behind it
module master #(
  parameter HALF     = 5,    // clk of 100 MHz: 10 MHz
  parameter BITS     = 32,   // of the position
  parameter PATIENCE = 500,  // clocks until the start bit: 40 us and more
  parameter SILENCE  = 2000  // clk until the next frame: 13 us and more
) (
  input                 clk,
  input                 reset,
  input                 start,
  output reg            ma,
  input                 slo,
  output reg            done,     // for one clk; what follows is valid then
  output reg            good,     // there was a frame, and its check sum is right
  output reg            error,    // the encoder tells one
  output reg            warning,
  output reg [BITS-1:0] position
);
  localparam IDLE = 0, FIRST = 1, ACK = 2, WAIT = 3, CDS = 4, DATA = 5, PAUSE = 6;
  localparam FRAME = BITS + 2 + 6; // behind CDS: position, nERR, nWARN, check sum

  reg [2:0]       state;
  reg [15:0]      divider;
  reg [15:0]      count;
  reg [FRAME-1:0] shift;
  reg [5:0]       crc;

  wire       tick   = divider == HALF - 1;
  wire       rising = tick && !ma && state != PAUSE;
  wire [5:0] next   = {crc[4:0], 1'b0} ^ (crc[5] ^ slo ? 6'h03 : 6'h00);

  task finish(input ok);
    begin
      good     <= ok;
      position <= shift[FRAME-1:8];
      error    <= !shift[7];
      warning  <= !shift[6];
      count    <= 0;
      state    <= PAUSE;
    end
  endtask

  always @(posedge clk) begin
    done    <= 0;
    divider <= state == IDLE || tick ? 0 : divider + 1;
    if (tick && state != PAUSE) ma <= !ma;
    if (reset) begin
      state <= IDLE;
      ma    <= 1;
    end else if (state == IDLE) begin
      count <= 0;
      crc   <= 0;
      if (start) state <= FIRST;
    end else if (state == PAUSE) begin
      ma    <= 1;
      count <= count + 1;
      if (count == SILENCE - 1) begin
        done  <= 1;
        state <= IDLE;
      end
    end else if (rising) begin
      count <= count + 1;
      case (state)
        FIRST: state <= ACK; // the first edge: the encoder latches its position
        ACK:   if (!slo) state <= WAIT;
        WAIT:  if (slo) state <= CDS;
        CDS: begin
          count <= 0;
          state <= DATA;
        end
        DATA: begin
          shift <= {shift[FRAME-2:0], slo};
          if (count < FRAME - 6) crc <= next;
        end
      endcase
      if (state < CDS && count == PATIENCE) finish(0);
    end else if (tick && state == DATA && count == FRAME) begin
      finish(shift[5:0] == ~crc);
    end
  end
endmodule
