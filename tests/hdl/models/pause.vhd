-- SPDX-License-Identifier: MIT
-- As pause.sv.
library ieee;
use ieee.std_logic_1164.all;
use std.textio.all;

entity pause is
end entity;

architecture test of pause is
  signal clk   : std_logic := '0';
  signal clock : std_logic := '1';
  signal data  : std_logic;
begin
  clk <= not clk after 6.667 ns;
  encoder : entity work.drehgeber_ssi generic map (MOTION => "90DEG") port map (clock => clock, data => data);

  process
    procedure wait_for(clocks : positive) is
    begin
      for i in 1 to clocks loop
        wait until rising_edge(clk);
      end loop;
    end procedure;
    variable word : std_logic_vector(25 downto 0);
  begin
    wait_for(100);
    for i in 0 to 25 loop
      clock <= '0';
      wait_for(75);
      clock <= '1';
      wait_for(2);
      word := word(24 downto 0) & data;
      wait_for(73);
    end loop;
    if word(25) = '1' then
      write(output, "word " & to_hstring("000" & word(24 downto 0)) & LF);
    else
      write(output, "no pause" & LF);
    end if;
    wait for 30 us; -- longer than the monoflop time
    write(output, "done" & LF);
    std.env.finish;
  end process;
end architecture;
