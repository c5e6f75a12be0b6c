// SPDX-License-Identifier: MIT
// What a test bench does to encoders, and what it is answered then; a line for each answer.
`timescale 1ps / 1ps
module asked;
  reg ma = 1'b1;
  wire slo;
  wire tx;
  wire de;
  wire real sine;
  wire real cosine;
  real value;
  reg [8*256-1:0] answer;

  drehgeber_biss #(.MODEL("s3674-biss"), .SETTINGS("st=12")) encoder (.ma(ma), .sli(1'b0), .slo(slo));
  drehgeber_rs485 line (.rx(1'b1), .tx(tx), .de(de), .sine(sine), .cosine(cosine));

  initial begin
    #200000000000;
    encoder.latched(value);
    $display("latched %0.0f", value);
    encoder.turn(0.5);
    encoder.position(value);
    $display("turn %0.0f", value);
    ma = 1'b0;
    #500000 ma = 1'b1;
    #500000 ma = 1'b0;
    #500000 ma = 1'b1;
    encoder.latched(value);
    $display("latched %0.0f", value);
    encoder.latched_at_us(value);
    $display("at %0.1f", value);
    encoder.speed(60000.0);
    #250000000 encoder.position(value);
    $display("speed %0.0f", value);
    encoder.motion("45DEG");
    encoder.position(value);
    $display("motion %0.0f", value);
    encoder.world("temperature", 41.5);
    encoder.command("WORLd:TEMPerature?", answer);
    $display("temperature %0s", answer);
    encoder.fault("temperature_high", 1'b1);
    encoder.command("WORLd:TEMPerature?", answer);
    $display("hot %0d", answer != "41.5");
    encoder.power(1'b0);
    encoder.command("POWer?", answer);
    $display("power %0s", answer);
    $display("volts %0.2f %0.2f", sine, cosine);
    line.turn(1.0 / 8192.0);
    #2000000 $display("volts %0.2f %0.2f", sine, cosine);
    $display("done");
    $finish;
  end
endmodule
