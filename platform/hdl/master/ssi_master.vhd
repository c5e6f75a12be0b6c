-- SPDX-License-Identifier: MIT
-- An SSI master: position, error bit and parity of one encoder, or its word as it came. VHDL-93.
--
--  clock ~~\_/~~\__/~~\__/ ... ~\__/~~~~~~~~~~~~~~~~
--          f1    f2               fn+1
--  data  ~~~~|MSB  |     |  ... |LSB  |____________/~~
--          ^ the position is that of f1   pause
--
-- Data moves on rising edges. Nothing in SSI says how long the line is: sample_delay does, from a
-- rising edge of clock to the look at data; it may be longer than a period, clock goes on meanwhile.
-- There is one clock more than the word has bits, and behind the word a 0: a 1 there is a word of
-- another length, or an encoder that does not answer. Data that is 0 at rest is a wire that is
-- broken or an encoder without power, or one that has not started yet.
library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

entity ssi_master is
  generic (
    CLK_HZ   : positive := 100000000;  -- frequency of clk, at most 500 MHz
    WORD_MAX : positive := 34          -- most bits of a word, 2..63
  );
  port (
    clk   : in std_logic;
    reset : in std_logic;  -- synchronous

    -- Settings. To be changed while cycle is '0' and the last word is done, or never.
    clock_half    : in unsigned(11 downto 0);  -- half a period of clock in clk, 2..4095: CLK_HZ / (2 * f)
    sample_delay  : in unsigned(11 downto 0);  -- from a rising edge to the look in clk, 3..4095: line both
                                               -- ways, encoder and two flip-flops, and half a period, say
    pause_us      : in unsigned(7 downto 0);   -- from the last edge to the next word, above the monoflop time
    position_bits : in unsigned(5 downto 0);   -- multiturn and singleturn, 1..WORD_MAX
    gray          : in std_logic;              -- '1': the position is in Gray code
    has_error     : in std_logic;              -- '1': an error bit follows
    has_parity    : in std_logic;              -- '1': a parity bit follows, over all bits before it
    parity_odd    : in std_logic;              -- '1': it makes the number of ones odd, '0': even

    -- Words
    cycle     : in  std_logic;                                -- '1': begin a word, and the next one when this is done
    latch     : out std_logic;                                -- one clk: f1 leaves; the position will be that of now
    done      : out std_logic;                                -- one clk: a word is over, all of what follows is valid
    status    : out std_logic_vector(1 downto 0);             -- STATUS_..., below
    word      : out std_logic_vector(WORD_MAX - 1 downto 0);  -- as it came, right-aligned
    position  : out std_logic_vector(WORD_MAX - 1 downto 0);  -- binary, right-aligned
    error     : out std_logic;                                -- the error bit, whichever level means one; '0' without one
    parity_ok : out std_logic;                                -- '1' without a parity bit

    -- Wire
    clock : out std_logic;
    data  : in  std_logic  -- asynchronous
  );
end entity;

architecture rtl of ssi_master is
  -- status
  constant STATUS_OK        : std_logic_vector(1 downto 0) := "00";
  constant STATUS_NOT_READY : std_logic_vector(1 downto 0) := "01";  -- data was 0 at rest: nothing was clocked
  constant STATUS_NO_STOP   : std_logic_vector(1 downto 0) := "10";  -- data was 1 behind the word
  constant STATUS_NO_PAUSE  : std_logic_vector(1 downto 0) := "11";  -- data is 0 after the pause: it was too short, or the line broke

  constant CLKS_A_US : positive := (CLK_HZ + 999999) / 1000000;

  type line_state is (IDLE, CLOCKS, DRAIN, PAUSE);

  function bit_of(condition : boolean) return std_logic is
  begin
    if condition then
      return '1';
    end if;
    return '0';
  end function;

  signal data_0, data_1 : std_logic := '0';  -- data_1 is safe
  signal tick_left      : integer range 0 to CLKS_A_US - 1 := 0;
  signal us             : std_logic := '0';  -- one clk in a microsecond

  signal state       : line_state := PAUSE;
  signal clock_out   : std_logic := '1';
  signal result      : std_logic_vector(1 downto 0) := STATUS_NOT_READY;
  signal half_left   : unsigned(11 downto 0) := (others => '0');
  signal half_end    : std_logic := '0';
  signal clocks_left : unsigned(5 downto 0) := (others => '0');
  signal waited_us   : unsigned(7 downto 0) := (others => '0');
  signal pause_over  : boolean := false;
  signal listening   : boolean := false;  -- data is looked at, from the first rising edge to the bit behind the word
  signal word_bits   : unsigned(5 downto 0);
  signal first_rise  : boolean;
  signal stop        : boolean;  -- the bit behind the word is looked at

  signal sample_left   : unsigned(12 downto 0) := (others => '0');
  signal sample        : std_logic := '0';
  signal position_left : unsigned(5 downto 0) := (others => '0');
  signal error_left    : std_logic := '0';
  signal parity_left   : std_logic := '0';
  signal parity        : std_logic := '0';  -- of all bits so far
  signal binary        : std_logic := '0';  -- the last one of the position, decoded
  signal next_binary   : std_logic;
  signal word_in       : std_logic_vector(WORD_MAX - 1 downto 0) := (others => '0');
  signal position_in   : std_logic_vector(WORD_MAX - 1 downto 0) := (others => '0');
begin
  clock    <= clock_out;
  status   <= result;
  word     <= word_in;
  position <= position_in;

  ------------------------------------------------------------------ data, and time
  process (clk)
  begin
    if rising_edge(clk) then
      data_0 <= data;
      data_1 <= data_0;
      us     <= bit_of(tick_left = 0);
      if reset = '1' or tick_left = 0 then
        tick_left <= CLKS_A_US - 1;
      else
        tick_left <= tick_left - 1;
      end if;
    end if;
  end process;

  ------------------------------------------------------------------ clock
  word_bits  <= position_bits + ("00000" & has_error) + ("00000" & has_parity);
  first_rise <= state = CLOCKS and half_end = '1' and clock_out = '0' and clocks_left = word_bits;

  process (clk)
  begin
    if rising_edge(clk) then
      latch     <= '0';
      done      <= '0';
      half_left <= half_left - 1;
      half_end  <= bit_of(half_left = 1 and state = CLOCKS);
      if us = '1' and waited_us /= 255 then
        waited_us <= waited_us + 1;
      end if;
      pause_over <= waited_us > pause_us;
      case state is
        when IDLE =>
          if cycle = '1' then
            half_left   <= clock_half - 1;
            clocks_left <= word_bits;
            waited_us   <= (others => '0');
            pause_over  <= false;
            clock_out   <= not data_1;
            latch       <= data_1;
            if data_1 = '1' then
              result <= STATUS_OK;
              state  <= CLOCKS;
            else
              result <= STATUS_NOT_READY;
              state  <= PAUSE;
            end if;
          end if;
        when CLOCKS =>
          if half_end = '1' then
            half_left <= clock_half - 1;
            clock_out <= not clock_out;
            if clock_out = '0' then
              clocks_left <= clocks_left - 1;
              if clocks_left = 0 then
                state <= DRAIN;
              end if;
            end if;
          end if;
        when DRAIN =>
          waited_us  <= (others => '0');
          pause_over <= false;
          if not listening then
            state <= PAUSE;
          end if;
        when PAUSE =>
          if pause_over then
            state <= IDLE;
            done  <= '1';
            if result = STATUS_OK and data_1 = '0' then
              result <= STATUS_NO_PAUSE;
            end if;
          end if;
      end case;
      if stop and data_1 = '1' then
        result <= STATUS_NO_STOP;
      end if;
      if reset = '1' then
        state      <= PAUSE;
        clock_out  <= '1';
        done       <= '0';
        waited_us  <= (others => '0');
        pause_over <= false;
        result     <= STATUS_NOT_READY;
      end if;
    end if;
  end process;

  ------------------------------------------------------------------ receiver
  next_binary <= data_1 xor (gray and binary);
  stop        <= listening and sample = '1' and position_left = 0 and error_left = '0' and parity_left = '0';

  process (clk)
  begin
    if rising_edge(clk) then
      sample <= bit_of(listening and sample_left = 0);
      if sample_left = 0 then
        sample_left <= (clock_half & '0') - 1;
      else
        sample_left <= sample_left - 1;
      end if;
      if first_rise then
        listening     <= true;
        sample        <= '0';
        sample_left   <= ('0' & sample_delay) - 2;
        position_left <= position_bits;
        error_left    <= has_error;
        parity_left   <= has_parity;
        word_in       <= (others => '0');
        position_in   <= (others => '0');
        error         <= '0';
        parity        <= '0';
        binary        <= '0';
      elsif listening and sample = '1' then
        if not stop then
          word_in <= word_in(WORD_MAX - 2 downto 0) & data_1;
          parity  <= parity xor data_1;
        end if;
        if position_left /= 0 then
          position_in   <= position_in(WORD_MAX - 2 downto 0) & next_binary;
          binary        <= next_binary;
          position_left <= position_left - 1;
        elsif error_left = '1' then
          error      <= data_1;
          error_left <= '0';
        elsif parity_left = '1' then
          parity_left <= '0';
        else
          listening <= false;
          parity_ok <= not has_parity or bit_of(parity = parity_odd);
        end if;
      end if;
      if reset = '1' then
        listening <= false;
      end if;
    end if;
  end process;
end architecture;
