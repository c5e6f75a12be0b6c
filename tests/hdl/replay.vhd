-- SPDX-License-Identifier: MIT
-- The BiSS-C master in VHDL does at every clock what that in Verilog did in biss_bench.sv, which has written a line
-- `CLOCK BITS` for each clock with a change: what went in at its rising edge, and what came out until then.
library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;
use std.textio.all;
use std.env.finish;

entity replay is
  generic (TRACE : string);
end entity;

architecture bench of replay is
  constant INPUTS  : positive := 40;
  constant OUTPUTS : positive := 92;

  signal clk  : std_logic := '0';
  signal what : std_logic_vector(INPUTS - 1 downto 0) := (others => '1');
  signal ma, latch, frame_done, word_done, busy, done : std_logic;
  signal frame, frame_seen : std_logic_vector(14 downto 0);
  signal word, word_seen   : std_logic_vector(59 downto 0);
  signal answer, answer_seen : std_logic_vector(10 downto 0);
begin
  master : entity work.biss_master
    generic map (SLAVES => 3)
    port map (
      clk => clk, reset => what(39), ma_half => unsigned(what(38 downto 27)),
      slave_count => unsigned(what(26 downto 23)), position_bits => "100000010001100001", life_counter => "101",
      cycle => what(22), latch => latch, frame_done => frame_done, frame_status => frame(14 downto 12),
      std_logic_vector(line_delay) => frame(11 downto 0), word_done => word_done,
      std_logic_vector(word_slave) => word(59 downto 57), word_position => word(56 downto 9), word_n_error => word(8),
      word_n_warning => word(7), word_crc_ok => word(6), std_logic_vector(word_life) => word(5 downto 0),
      register_start => what(21), register_write => what(20), register_more => what(19),
      register_id => unsigned(what(18 downto 16)), register_address => what(15 downto 9),
      register_wdata => what(8 downto 1), register_busy => busy, register_done => done,
      register_rdata => answer(10 downto 3), register_status => answer(2 downto 0), ma => ma, sl => what(0));

  -- What is not valid is not compared.
  frame_seen  <= frame when frame_done = '1' else (others => '0');
  word_seen   <= word when word_done = '1' else (others => '0');
  answer_seen <= answer when done = '1' else (others => '0');

  process
    file source     : text open read_mode is TRACE;
    variable row    : line;
    variable at, to_clock, words, answers : natural := 0;
    variable bits, ahead : bit_vector(INPUTS + OUTPUTS - 1 downto 0);
    variable seen   : std_logic_vector(OUTPUTS - 1 downto 0);
  begin
    readline(source, row);
    read(row, at);
    read(row, bits);
    while not endfile(source) loop
      readline(source, row);
      read(row, to_clock);
      read(row, ahead);
      while at < to_clock loop
        what <= to_stdlogicvector(bits(INPUTS + OUTPUTS - 1 downto OUTPUTS));
        clk  <= '0';
        wait for 5 ns;
        seen := ma & latch & frame_done & word_done & busy & done & frame_seen & word_seen & answer_seen;
        assert what(39) = '1' or seen = to_stdlogicvector(bits(OUTPUTS - 1 downto 0))
          report "clock " & integer'image(at) & ": " & to_hstring(seen) & ", not " & to_hstring(bits(OUTPUTS - 1 downto 0))
          severity failure;
        if word_done = '1' then
          words := words + 1;
        end if;
        if done = '1' then
          answers := answers + 1;
        end if;
        clk <= '1';
        wait for 5 ns;
        at := at + 1;
      end loop;
      bits := ahead;
    end loop;
    report "equal for " & integer'image(at) & " clocks with " & integer'image(words) & " words and " &
      integer'image(answers) & " registers";
    finish;
  end process;
end architecture;
