// SPDX-License-Identifier: MIT
// An SSI master that looks for the 1 in front of the word: it takes data two of its clocks behind each rising edge, when
// data is still what it was before that edge. pause.vhd does the same.
`timescale 1ns / 1ps
module pause;
  reg clk = 0, clock = 1;
  reg [25:0] word;  // the 1, and 25 bits in Gray code
  wire data;
  integer i;
  always #6.667 clk = !clk;  // 75 MHz

`ifdef TCO_NS
  drehgeber_ssi #(.MOTION("90DEG"), .TCO_NS(`TCO_NS)) encoder (.clock(clock), .data(data));
`else
  drehgeber_ssi #(.MOTION("90DEG")) encoder (.clock(clock), .data(data));
`endif

  initial begin
    if ($test$plusargs("vcd")) begin
      $dumpfile("pause.vcd");
      $dumpvars(0, clock, data);
    end
    repeat (100) @(posedge clk);
    for (i = 0; i < 26; i = i + 1) begin
      clock = 0;
      repeat (75) @(posedge clk);  // 500 kHz
      clock = 1;
      repeat (2) @(posedge clk);
      word = {word[24:0], data};
      repeat (73) @(posedge clk);
    end
    if (word[25]) $display("word %h", word[24:0]);
    else $display("no pause");
    #30000 $display("done");  // longer than the monoflop time
    $finish;
  end
endmodule
