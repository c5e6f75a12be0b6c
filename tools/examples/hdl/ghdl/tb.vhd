-- SPDX-License-Identifier: MIT
-- A test bench of ../cocotb_ghdl/biss_reader.vhd for GHDL, with the VHDL model: an encoder that turns, whose processing time
-- is another one in every frame, and which then has a defect. Ends with `ok`, or with a failure.
library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;
use std.textio.all;
use work.drehgeber_hdl.all;

entity tb is
end entity;

architecture test of tb is
  signal clk, start               : std_logic := '0';
  signal ma, slo, done            : std_logic;
  signal n_error, n_warning, good : std_logic;
  signal position                 : unsigned(32 downto 0);
  signal life                     : unsigned(5 downto 0);
begin
  clk <= not clk after 10 ns;

  dut : entity work.biss_reader
    port map (clk => clk, start => start, ma => ma, slo => slo, done => done, position => position,
              n_error => n_error, n_warning => n_warning, life => life, crc_ok => good);

  encoder : entity work.drehgeber_biss
    generic map (NAME => "axis", SETTINGS => "busy_us=2 busy_jitter_us=5", MOTION => "3000RPM")
    port map (ma => ma, slo => slo);

  process
    procedure read_position(in_order : std_logic) is
    begin
      start <= '1';
      wait until rising_edge(clk) and done = '1';
      start <= '0';
      assert good = '1' and n_error = in_order and std_logic_vector(position) = to_bits(latched("axis"), 33)
        report "position " & to_hstring(position) & ", was latched: " & to_hstring(to_bits(latched("axis"), 33))
        severity failure;
    end procedure;
  begin
    for i in 1 to 50 loop
      read_position('1');
    end loop;
    for i in 1 to 50 loop
      turn("axis", 0.7321 * real(i));
      read_position('1');
    end loop;
    fault("axis", "led_current_high");
    read_position('0');
    fault("axis", "led_current_high", false);
    read_position('1');
    write(output, "ok" & LF);
    std.env.finish;
  end process;
end architecture;
