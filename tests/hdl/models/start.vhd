-- SPDX-License-Identifier: MIT
-- As start.sv.
library ieee;
use ieee.std_logic_1164.all;
use std.textio.all;

entity start is
end entity;

architecture test of start is
  signal zero, at_once                                    : std_logic := '0';
  signal unknown, pulsing, late                           : std_logic;
  signal of_zero, of_unknown, of_pulsing, of_at_once      : std_logic;
  signal of_late, near, far, data                         : std_logic;
begin
  a : entity work.drehgeber_biss generic map (NAME => "a") port map (ma => zero, slo => of_zero);
  b : entity work.drehgeber_biss generic map (NAME => "b") port map (ma => unknown, slo => of_unknown);
  c : entity work.drehgeber_biss generic map (NAME => "c", MA_DELAY_NS => 20.0) port map (ma => at_once, slo => of_at_once);
  d : entity work.drehgeber_biss generic map (NAME => "d") port map (ma => pulsing, slo => of_pulsing);
  e : entity work.drehgeber_biss
    generic map (NAME => "e", SETTINGS => "power_on_ns=20") port map (ma => late, slo => of_late);
  f : entity work.drehgeber_biss generic map (NAME => "f") port map (ma => '1', sli => far, slo => near);
  g : entity work.drehgeber_biss generic map (NAME => "g") port map (ma => '1', slo => far);
  h : entity work.drehgeber_ssi generic map (NAME => "h", MOTION => "90DEG") port map (clock => at_once, data => data);

  process
    procedure tell(name : string; level : std_logic) is
    begin
      write(output, name & " " & std_logic'image(level)(2) & LF);
    end procedure;
  begin
    at_once <= '1'; -- one delta behind the beginning
    pulsing <= '1';
    late <= '1';
    wait for 3 ns;
    late <= '0';
    wait for 2 ns;
    zero <= '1';
    unknown <= '1';
    late <= '1';
    pulsing <= '0';
    wait for 5 ns;
    pulsing <= '1';
    wait for 98990 ns;
    tell("zero", of_zero);
    tell("unknown", of_unknown);
    tell("at_once", of_at_once);
    tell("pulsing", of_pulsing);
    tell("late", of_late);
    tell("near", near);
    tell("data", data);
    wait for 2000 ns;
    write(output, "done" & LF);
    std.env.finish;
  end process;
end architecture;
