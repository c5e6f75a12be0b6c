// SPDX-License-Identifier: MIT
// A small BiSS-C master, as somebody may have written it: positions of one encoder, without registers and
// without compensation of the line. ma is clk / (2 * HALF).
`timescale 1ns / 1ps

module biss_reader #(
    parameter HALF = 25,  // half a period of ma in clk
    parameter POSITION = 33  // bits, multiturn and singleturn
) (
    input wire clk,
    input wire start,
    output reg ma,
    input wire slo,
    output reg done,  // one clk; what follows is valid
    output reg [POSITION-1:0] position,
    output reg n_error,
    output reg n_warning,
    output reg [5:0] life,
    output reg crc_ok
);
  localparam DATA = POSITION + 2 + 6;  // nERR, nWARN, life counter
  localparam [2:0] IDLE = 0, FIRST = 1, ACK = 2, START = 3, CDS = 4, BITS = 5, TIMEOUT = 6;

  reg [2:0] state = IDLE;
  reg [7:0] wait_left = 0;
  reg [6:0] bits_left = 0;
  reg [DATA+5:0] word = 0;
  reg [5:0] crc = 0;
  initial {ma, done} = 2'b10;

  wire tick = wait_left == 0;
  wire in_data = bits_left > 7;  // the check sum behind it comes inverted
  wire feedback = crc[5] ^ slo ^ !in_data;

  always @(posedge clk) begin
    done <= 0;
    wait_left <= tick ? HALF - 1 : wait_left - 1;
    if (state == IDLE) begin
      if (start) state <= FIRST;
    end else if (state == TIMEOUT) begin
      ma <= 1;  // CDM = 0
      if (slo) begin
        {position, n_error, n_warning, life} <= word[DATA+5:6];
        crc_ok <= crc == 0;
        done <= 1;
        state <= IDLE;
      end
    end else if (tick) begin
      ma <= !ma;
      if (ma)  // slo has had half a period and more since the rising edge
        case (state)
          FIRST: state <= ACK;
          ACK: if (!slo) state <= START;
          START: if (slo) state <= CDS;
          CDS: begin
            state <= BITS;
            bits_left <= DATA + 6 + 1;  // behind them slo is 0 until the timeout is over
            crc <= 0;
          end
          default: begin
            bits_left <= bits_left - 1;
            if (bits_left == 1) begin
              ma <= 1;
              state <= TIMEOUT;
            end else begin
              word <= {word[DATA+4:0], slo};
              crc <= {crc[4:0], 1'b0} ^ (feedback ? 6'h03 : 6'h00);
            end
          end
        endcase
    end
  end
endmodule
