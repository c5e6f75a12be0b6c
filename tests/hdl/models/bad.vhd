-- SPDX-License-Identifier: MIT
-- As bad.sv.
library ieee;
use ieee.std_logic_1164.all;

entity bad is
end entity;

architecture test of bad is
  signal slo : std_logic;
begin
  encoder : entity work.drehgeber_biss
    generic map (SETTINGS => "st=99")
    port map (ma => '1', slo => slo);
end architecture;
