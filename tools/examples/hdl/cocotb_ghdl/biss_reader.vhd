-- SPDX-License-Identifier: MIT
-- A small BiSS-C master, as somebody may have written it: positions of one encoder, without registers and
-- without compensation of the line. ma is clk / (2 * HALF).
library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

entity biss_reader is
  generic (
    HALF          : positive := 25;  -- half a period of ma in clk
    POSITION_BITS : positive := 33   -- multiturn and singleturn
  );
  port (
    clk       : in  std_logic;
    start     : in  std_logic;
    ma        : out std_logic := '1';
    slo       : in  std_logic;
    done      : out std_logic := '0';  -- one clk; what follows is valid
    position  : out unsigned(POSITION_BITS - 1 downto 0);
    n_error   : out std_logic;
    n_warning : out std_logic;
    life      : out unsigned(5 downto 0);
    crc_ok    : out std_logic
  );
end entity;

architecture rtl of biss_reader is
  constant DATA : positive := POSITION_BITS + 2 + 6;  -- nERR, nWARN, life counter

  type state_t is (IDLE, FIRST, ACK, START_BIT, CDS, BITS, TIMEOUT);
  signal state     : state_t := IDLE;
  signal level     : std_logic := '1';
  signal wait_left : natural range 0 to HALF - 1 := 0;
  signal bits_left : natural range 0 to DATA + 7 := 0;
  signal word      : std_logic_vector(DATA + 5 downto 0);
  signal crc       : std_logic_vector(5 downto 0);
begin
  ma <= level;

  process (clk)
    variable feedback : std_logic;
  begin
    if rising_edge(clk) then
      done <= '0';
      if wait_left = 0 then
        wait_left <= HALF - 1;
      else
        wait_left <= wait_left - 1;
      end if;
      if state = IDLE then
        if start = '1' then
          state <= FIRST;
        end if;
      elsif state = TIMEOUT then
        level <= '1';  -- CDM = 0
        if slo = '1' then
          position <= unsigned(word(DATA + 5 downto 14));
          n_error <= word(13);
          n_warning <= word(12);
          life <= unsigned(word(11 downto 6));
          if crc = "000000" then
            crc_ok <= '1';
          else
            crc_ok <= '0';
          end if;
          done <= '1';
          state <= IDLE;
        end if;
      elsif wait_left = 0 then
        level <= not level;
        if level = '1' then  -- slo has had half a period and more since the rising edge
          case state is
            when FIRST => state <= ACK;
            when ACK =>
              if slo = '0' then
                state <= START_BIT;
              end if;
            when START_BIT =>
              if slo = '1' then
                state <= CDS;
              end if;
            when CDS =>
              state <= BITS;
              bits_left <= DATA + 6 + 1;  -- behind them slo is 0 until the timeout is over
              crc <= "000000";
            when others =>
              feedback := crc(5) xor slo;
              if bits_left <= 7 then  -- the check sum comes inverted
                feedback := not feedback;
              end if;
              bits_left <= bits_left - 1;
              if bits_left = 1 then
                level <= '1';
                state <= TIMEOUT;
              else
                word <= word(DATA + 4 downto 0) & slo;
                crc <= crc(4 downto 1) & (crc(0) xor feedback) & feedback;
              end if;
          end case;
        end if;
      end if;
    end if;
  end process;
end architecture;
