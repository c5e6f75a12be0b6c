// SPDX-License-Identifier: MIT
// An encoder whose inputs and commands come from the file play.orders: PS KIND TEXT, one a line. What it answers is a line
// "= TEXT", each change of its line "@PS LEVEL". play_hdl.py writes the orders, and names the macros.
`timescale 1ps / 1ps
module play;
  reg in, behind;
  wire out;
  reg [63:0] at, now;
  reg [8*256-1:0] text, answer;
  real counts;
  integer orders, kind, got;

`ifdef BISS
  drehgeber_biss #(.MODEL(`MODEL), .SETTINGS(`SETTINGS)) it (.ma(in), .sli(behind), .slo(out));
`elsif SSI
  drehgeber_ssi #(.MODEL(`MODEL), .SETTINGS(`SETTINGS)) it (.clock(in), .data(out));
`else
  drehgeber_rs485 #(.MODEL(`MODEL), .SETTINGS(`SETTINGS), .SINCOS_NS(0.0)) it (.rx(in), .tx(out), .de(), .sine(),
                                                                               .cosine());
`endif

  always @(out) begin
    now = $time;
    $display("@%0d %b", now, out);
  end

  initial begin
    in = 1;
    behind = 0;
    orders = $fopen("play.orders", "r");
    got = $fscanf(orders, "%d %d", at, kind);
    while (got == 2) begin
      #(at - $time);
      got = $fgets(text, orders);
      case (kind)
        0: in = 0;
        1: in = 1;
        2: behind = 0;
        3: behind = 1;
        4: begin
          it.command(text, answer);
          $display("= %0s", answer);
        end
        5: begin
          it.position(counts);
          $display("= %0.0f", counts);
        end
        6: $display("= %b", out);
      endcase
      got = $fscanf(orders, "%d %d", at, kind);
    end
    $finish;
  end
endmodule
