-- SPDX-License-Identifier: MIT
-- As short.sv.
library ieee;
use ieee.std_logic_1164.all;
use std.textio.all;

entity short is
end entity;

architecture test of short is
  signal slo : std_logic;
begin
  encoder : entity work.drehgeber_biss port map (ma => '1', slo => slo);
  process
  begin
    wait for 1000 ns;
    write(output, "done" & LF);
    std.env.finish;
  end process;
end architecture;
