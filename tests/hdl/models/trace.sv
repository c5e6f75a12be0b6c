// SPDX-License-Identifier: MIT
// The same in every simulator with Verilog: what each encoder's line does, a line of text for every change. trace.vhd
// does the same. The test bench has another time unit than the models.
`timescale 1ps / 1ps
module teller #(
    parameter NAME = ""
) (
    input level
);
  reg [63:0] t;
  always @(level) begin
    t = $time;
    $display("%0s %0d %0d %b", NAME, t / 1000000, t % 1000000, level);
  end
endmodule

`timescale 1ns / 1ps
module trace;
  reg ma, clock, rx;
  wire a, b, c, near, behind, data, tx, de;
  real latched_a;
  integer i, k;

  drehgeber_biss #(.SETTINGS("busy_us=2 busy_jitter_us=9"), .JITTER_NS(4.0), .MA_DELAY_NS(12.5), .SLO_DELAY_NS(33.3),
                   .SEED(7), .MOTION("600RPM")) of_a (.ma(ma), .sli(1'b0), .slo(a));
  drehgeber_biss #(.SETTINGS("busy_us=2 busy_jitter_us=9"), .JITTER_NS(4.0), .MA_DELAY_NS(12.5), .SLO_DELAY_NS(33.3),
                   .SEED(7), .MOTION("600RPM")) of_b (.ma(ma), .sli(1'b0), .slo(b));
  drehgeber_biss #(.SETTINGS("busy_us=2 busy_jitter_us=9"), .JITTER_NS(4.0), .MA_DELAY_NS(12.5), .SLO_DELAY_NS(33.3),
                   .SEED(8), .MOTION("600RPM")) of_c (.ma(ma), .sli(1'b0), .slo(c));
  drehgeber_biss #(.MOTION("90DEG")) of_near (.ma(ma), .sli(behind), .slo(near));
  drehgeber_biss #(.MODEL("s3674-biss"), .MOTION("45DEG"), .TCO_NS(7.25)) of_behind (.ma(ma), .sli(1'b0), .slo(behind));
  drehgeber_ssi #(.MOTION("90DEG")) of_data (.clock(clock), .data(data));
  drehgeber_rs485 #(.SINCOS_NS(0.0)) of_tx (.rx(rx), .tx(tx), .de(de), .sine(), .cosine());

  teller #("a") tell_a (a);
  teller #("b") tell_b (b);
  teller #("c") tell_c (c);
  teller #("near") tell_near (near);
  teller #("behind") tell_behind (behind);
  teller #("data") tell_data (data);
  teller #("tx") tell_tx (tx);
  teller #("de") tell_de (de);

  task put(input [7:0] character);
    integer bit_at;
    begin
      rx = 0;
      #104166;
      for (bit_at = 0; bit_at < 8; bit_at = bit_at + 1) begin
        rx = character[bit_at];
        #104166;
      end
      rx = ^character;
      #104166 rx = 1;
      #104166;
    end
  endtask

  initial begin
    ma = 1;
    clock = 1;
    rx = 1;
    #1000;
    for (i = 0; i < 4; i = i + 1) begin
      for (k = 0; k < 150; k = k + 1) begin
        #250 ma = 0;
        #250 ma = 1;
      end
      #20000;
      of_near.turn(0.125 * i);
      if (i == 1) of_behind.fault("led_current_high", 1'b1);
      if (i == 2) of_near.power(1'b0);
    end
    for (k = 0; k < 26; k = k + 1) begin
      #500 clock = 0;
      #500 clock = 1;
    end
    put(8'h40);
    put(8'h42);
    put(8'h02);
    repeat (20) #1000000;
    of_tx.power(1'b0);
    #1000 $display("done");
    $finish;
  end
endmodule
