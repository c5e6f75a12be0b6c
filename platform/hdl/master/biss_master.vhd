-- SPDX-License-Identifier: MIT
-- A BiSS-C master: position, errors and registers of up to SLAVES encoders in a chain. VHDL-93.
--
--        e1    e2    e3                           last  stop      timeout
--  ma ~\_/~~\__/~~\__/~~\__/ ... ~~\__/~~\__/~~\__/~~\__/~~~~ CDM = 0 ~~~~
--                                                       \____ CDM = 1 ____/
--  sl ~~~~~~~~\_Ack ..._/Start\CDS X data ... X nERR X nWARN X LC X CRC\______/~
--
-- The position is that of e1. The encoder answers at rising edges of ma; line and drivers delay
-- that, by more than a period at will. So sl is not sampled by ma: Ack, the falling edge of sl
-- behind e2, says where its bits begin, in each frame anew, and each is taken in its middle. Until
-- the last one has come ma goes on; clocks beyond the CRC shift nothing.
--
-- From the power-on of an encoder sl may be low until e1: a frame starts without a look at sl.
-- What the encoder ends a frame with is that it sets sl again: that is waited for.
--
-- Registers go along with frames, a bit in each: ma during the timeout (CDM) and the bit behind the
-- start bit (CDS). An access is 33 frames for the first register and 14 for each that follows.
-- It needs frames: hold cycle at '1'.
library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

entity biss_master is
  generic (
    CLK_HZ       : positive := 100000000;  -- frequency of clk, at most 500 MHz
    SLAVES       : positive := 1;          -- most encoders in the chain, 1..8
    POSITION_MAX : positive := 48;         -- most bits of a position, multiturn and singleturn, 12..63
    BUSY_US      : positive := 40          -- longest processing time, from Ack on, at most 250; e1 to Ack as long
  );
  port (
    clk   : in std_logic;
    reset : in std_logic;  -- synchronous; a bus reset of 40 us follows

    -- Settings. To be changed while cycle is '0' and the last frame is done, or never.
    ma_half       : in unsigned(11 downto 0);  -- half a period of ma in clk, 2..4095: CLK_HZ / (2 * f)
    slave_count   : in unsigned(3 downto 0);   -- encoders in the chain, 1..SLAVES
    position_bits : in std_logic_vector(6 * SLAVES - 1 downto 0);  -- of each; that nearest to the master in 5..0
    life_counter  : in std_logic_vector(SLAVES - 1 downto 0);      -- '1': its frame has the six bits LC

    -- Frames
    cycle        : in  std_logic;                     -- '1': begin a frame, and the next one when this is done
    latch        : out std_logic;                     -- one clk: e1 leaves; the position will be that of now
    frame_done   : out std_logic;                     -- one clk: a frame is over, frame_status is valid
    frame_status : out std_logic_vector(2 downto 0);  -- FRAME_..., below
    line_delay   : out unsigned(11 downto 0);         -- from e2 to Ack in clk: line both ways, encoder, two flip-flops

    -- What an encoder said; valid with word_done until the next one
    word_done      : out std_logic;                                    -- one clk
    word_slave     : out unsigned(2 downto 0);                         -- which one, 0 is nearest to the master
    word_position  : out std_logic_vector(POSITION_MAX - 1 downto 0);  -- multiturn and singleturn, right-aligned
    word_n_error   : out std_logic;                                    -- '0' is an error
    word_n_warning : out std_logic;                                    -- '0' is a warning
    word_life      : out unsigned(5 downto 0);                         -- life counter; 0 without one
    word_crc_ok    : out std_logic;                                    -- the check sum fits: use the rest only then

    -- Registers
    register_start   : in  std_logic;                     -- one clk, while register_busy is '0': begin an access
    register_write   : in  std_logic;                     -- '1': write, '0': read       taken with register_start
    register_id      : in  unsigned(2 downto 0);          -- of the encoder              "
    register_address : in  std_logic_vector(6 downto 0);  -- of the first register       "
    register_wdata   : in  std_logic_vector(7 downto 0);  -- to write                    ", and with each register_done
    register_more    : in  std_logic;                     -- one more register behind this one: taken with register_done
    register_busy    : out std_logic;                     -- '1' until the last register is done
    register_done    : out std_logic;                     -- one clk: a register is done, the next two are valid
    register_rdata   : out std_logic_vector(7 downto 0);  -- read, or the echo of what was written
    register_status  : out std_logic_vector(2 downto 0);  -- REGISTER_..., below; an access ends with any but OK

    -- Wire
    ma : out std_logic;
    sl : in  std_logic  -- asynchronous
  );
end entity;

architecture rtl of biss_master is
  -- frame_status
  constant FRAME_OK         : std_logic_vector(2 downto 0) := "000";
  constant FRAME_NO_ACK     : std_logic_vector(2 downto 0) := "001";  -- sl did not fall behind e2
  constant FRAME_NO_START   : std_logic_vector(2 downto 0) := "010";  -- no start bit within BUSY_US
  constant FRAME_NO_STOP    : std_logic_vector(2 downto 0) := "011";  -- sl is high behind the last bit: another length, or stuck
  constant FRAME_NO_TIMEOUT : std_logic_vector(2 downto 0) := "100";  -- sl is still low after 40 us

  -- register_status
  constant REGISTER_OK        : std_logic_vector(2 downto 0) := "000";
  constant REGISTER_REFUSED   : std_logic_vector(2 downto 0) := "001";  -- the encoder does not have it, or does not permit this
  constant REGISTER_CHECK     : std_logic_vector(2 downto 0) := "010";  -- CRC of what was read, or echo of what was written, is wrong
  constant REGISTER_LATE      : std_logic_vector(2 downto 0) := "011";  -- the encoder is busy for more than 20 ms
  constant REGISTER_NO_ANSWER : std_logic_vector(2 downto 0) := "100";  -- nobody has this ID, or the address was not understood
  constant REGISTER_LINE      : std_logic_vector(2 downto 0) := "101";  -- a frame failed meanwhile

  constant BUS_RESET_US : positive := 40;
  constant BUSY_R_US    : positive := 20000;
  constant ZEROS_MIN    : positive := 14;
  constant CLKS_A_US    : positive := (CLK_HZ + 999999) / 1000000;

  type frame_state is (PAUSE, IDLE, CLOCK, TIMEOUT, RETURN_HIGH);
  type receiver_state is (R_OFF, R_ACK, R_START, R_CDS, R_DATA, R_CRC, R_STOP);

  -- x^6 + x + 1, over everything behind CDS; it comes inverted: with it, inverted, the rest is 0.
  function crc6_next(crc : std_logic_vector(5 downto 0); data : std_logic) return std_logic_vector is
    variable feed : std_logic;
  begin
    feed := crc(5) xor data;
    return crc(4 downto 1) & (crc(0) xor feed) & feed;
  end function;

  -- x^4 + x + 1, inverted, over CTS, ID, ADR, and over data.
  function crc4_next(crc : std_logic_vector(3 downto 0); data : std_logic) return std_logic_vector is
    variable feed : std_logic;
  begin
    feed := crc(3) xor data;
    return crc(2 downto 1) & (crc(0) xor feed) & feed;
  end function;

  function bit_of(condition : boolean) return std_logic is
  begin
    if condition then
      return '1';
    end if;
    return '0';
  end function;

  signal sl_0, sl_1, sl_2 : std_logic := '0';  -- sl_1 is safe, sl_2 is sl_1 of one clk ago
  signal tick_left        : integer range 0 to CLKS_A_US - 1 := 0;
  signal us               : std_logic := '0';  -- one clk in a microsecond

  signal state       : frame_state := PAUSE;
  signal receiver    : receiver_state := R_OFF;
  signal half_left   : unsigned(11 downto 0) := (others => '0');  -- of the half period of ma
  signal half_end    : std_logic := '0';                          -- this is its last clk
  signal sample_left : unsigned(12 downto 0) := (others => '0');  -- to the middle of the next bit of sl
  signal sample      : std_logic := '0';                          -- it is here
  signal clocks      : unsigned(3 downto 0) := (others => '0');   -- rising edges since the start of the frame, or Ack; 15 are many
  signal over        : std_logic := '0';                          -- the last clock is the one that runs
  signal delay       : unsigned(11 downto 0) := (others => '0');  -- since e2
  signal status      : std_logic_vector(2 downto 0) := FRAME_OK;
  signal ma_out      : std_logic := '1';

  signal ack, too_late, no_ack, no_start, no_stop, no_timeout, failed, last_edge : boolean;
  signal whole       : boolean;  -- the frame is here, CDM is to be chosen

  -- Since the start of the frame, Ack, the last edge, or the begin of a pause.
  signal waited_us  : unsigned(7 downto 0) := (others => '0');
  signal busy_over  : boolean := false;
  signal pause_over : boolean := false;

  signal word          : std_logic_vector(POSITION_MAX + 7 downto 0) := (others => '0');  -- position, nERR, nWARN, LC
  signal crc6          : std_logic_vector(5 downto 0) := (others => '0');
  signal crc6_with     : std_logic_vector(5 downto 0);
  signal bits_left     : unsigned(6 downto 0) := (others => '0');
  signal data_bits     : unsigned(6 downto 0);
  signal slaves_left   : unsigned(3 downto 0) := (others => '0');
  signal slave         : unsigned(2 downto 0) := (others => '0');
  signal positions     : std_logic_vector(6 * SLAVES - 1 downto 0) := (others => '0');  -- of the encoders that are still to come
  signal life_counters : std_logic_vector(SLAVES - 1 downto 0) := (others => '0');      -- "
  signal with_life     : std_logic := '0';
  signal ready         : boolean;
  signal cds           : std_logic := '0';
  signal cdm           : std_logic := '0';

  signal pending  : std_logic := '0';  -- an access waits or runs
  signal write    : std_logic := '0';
  signal id       : unsigned(2 downto 0) := (others => '0');
  signal zeros    : integer range 0 to ZEROS_MIN := 0;  -- frames with CDM = 0
  signal step     : integer range 0 to 32 := 0;
  signal sent     : std_logic_vector(10 downto 0) := (others => '0');  -- what goes out, at its left end
  signal crc4     : std_logic_vector(3 downto 0) := (others => '0');
  signal id_there : std_logic := '0';  -- IDL: a slave has this ID
  signal r_echo   : std_logic := '0';
  signal fits     : std_logic := '0';  -- all that was written came back
  signal checked  : boolean;
  signal start_us : unsigned(14 downto 0) := (others => '0');  -- since S
  signal late     : boolean := false;                                  -- that is too long
  signal rdata    : std_logic_vector(7 downto 0) := (others => '0');
begin
  ma             <= ma_out;
  frame_status   <= status;
  register_busy  <= pending;
  register_rdata <= rdata;

  ------------------------------------------------------------------ sl, and time
  process (clk)
  begin
    if rising_edge(clk) then
      sl_0 <= sl;
      sl_1 <= sl_0;
      sl_2 <= sl_1;
      us   <= bit_of(tick_left = 0);
      if reset = '1' or tick_left = 0 then
        tick_left <= CLKS_A_US - 1;
      else
        tick_left <= tick_left - 1;
      end if;
    end if;
  end process;

  process (clk)
  begin
    if rising_edge(clk) then
      if reset = '1' or state = IDLE or ack or last_edge or no_timeout then
        waited_us  <= (others => '0');
        busy_over  <= false;
        pause_over <= false;
      else
        if us = '1' and waited_us /= 255 then
          waited_us <= waited_us + 1;
        end if;
        busy_over  <= waited_us > BUSY_US;
        pause_over <= waited_us > BUS_RESET_US;
      end if;
    end if;
  end process;

  ------------------------------------------------------------------ frame
  ack        <= receiver = R_ACK and clocks >= 2 and sl_2 = '1' and sl_1 = '0';
  -- At a slow clock BUSY_US are few clocks, and each encoder of a chain takes one for itself.
  too_late   <= busy_over and clocks = 15;
  no_ack     <= receiver = R_ACK and too_late;
  no_start   <= receiver = R_START and sample = '1' and sl_1 = '0' and too_late;
  no_stop    <= receiver = R_STOP and sample = '1' and sl_1 = '1';
  no_timeout <= state = TIMEOUT and sl_1 = '0' and pause_over;
  failed     <= no_ack or no_start or no_stop or no_timeout;
  whole      <= receiver = R_STOP and sample = '1' and sl_1 = '0';
  last_edge  <= state = CLOCK and half_end = '1' and ma_out = '1' and over = '1';

  process (clk)
  begin
    if rising_edge(clk) then
      latch      <= '0';
      frame_done <= '0';
      half_left  <= half_left - 1;
      half_end   <= bit_of(half_left = 1 and (state = CLOCK or state = RETURN_HIGH));
      case state is
        when PAUSE =>
          ma_out <= '1';
          if pause_over then
            state <= IDLE;
          end if;
        when IDLE =>
          if cycle = '1' then
            state     <= CLOCK;
            ma_out    <= '0';
            half_left <= ma_half - 1;
            clocks    <= (others => '0');
            over      <= '0';
          end if;
        when CLOCK =>
          if half_end = '1' then
            half_left <= ma_half - 1;
            ma_out    <= not ma_out;
            if ma_out = '0' then
              latch <= bit_of(clocks = 0 and receiver = R_ACK);
              if clocks /= 15 then
                clocks <= clocks + 1;
              end if;
            elsif over = '1' then
              if status = FRAME_OK then
                ma_out <= not cdm;
                state  <= TIMEOUT;
              else
                ma_out     <= '1';
                state      <= PAUSE;
                frame_done <= '1';
              end if;
            end if;
          end if;
        when TIMEOUT =>
          if sl_1 = '1' then
            ma_out    <= '1';
            half_left <= ma_half - 1;
            state     <= RETURN_HIGH;
          elsif no_timeout then
            frame_done <= '1';
            state      <= PAUSE;
          end if;
        when RETURN_HIGH =>  -- ma is high for half a period at least
          if half_end = '1' then
            frame_done <= '1';
            state      <= IDLE;
          end if;
      end case;
      if ack then
        clocks <= (others => '0');
      end if;
      if whole or failed then
        over <= '1';
      end if;
      if state = IDLE then
        status <= FRAME_OK;
      elsif no_ack then
        status <= FRAME_NO_ACK;
      elsif no_start then
        status <= FRAME_NO_START;
      elsif no_stop then
        status <= FRAME_NO_STOP;
      elsif no_timeout then
        status <= FRAME_NO_TIMEOUT;
      end if;
      if reset = '1' then
        state  <= PAUSE;
        ma_out <= '1';
        status <= FRAME_OK;
      end if;
    end if;
  end process;

  ------------------------------------------------------------------ receiver
  crc6_with <= crc6_next(crc6, sl_1 xor bit_of(receiver = R_CRC));
  data_bits <= ('0' & unsigned(positions(5 downto 0))) + 8 when life_counters(0) = '1' else
               ('0' & unsigned(positions(5 downto 0))) + 2;
  ready     <= sample = '1' and (receiver = R_CDS or (receiver = R_CRC and bits_left = 1));

  process (clk)
  begin
    if rising_edge(clk) then
      word_done <= '0';
      if clocks < 2 then
        delay <= (others => '0');
      elsif delay /= 4095 then
        delay <= delay + 1;
      end if;
      sample <= bit_of(sample_left = 0 and receiver /= R_ACK);
      if sample_left = 0 then
        sample_left <= (ma_half & '0') - 1;
      else
        sample_left <= sample_left - 1;
      end if;
      case receiver is
        when R_OFF =>
          if state = IDLE and cycle = '1' then
            receiver      <= R_ACK;
            positions     <= position_bits;
            life_counters <= life_counter;
            slaves_left   <= slave_count;
            slave         <= (others => '0');
          end if;
        when R_ACK =>
          if ack then
            receiver    <= R_START;
            line_delay  <= delay;
            sample_left <= ('0' & ma_half) - 2;
          end if;
        when R_START =>
          if sample = '1' and sl_1 = '1' then
            receiver <= R_CDS;
          end if;
        when R_CDS =>
          if sample = '1' then
            cds      <= sl_1;
            receiver <= R_DATA;
          end if;
        when R_DATA =>
          if sample = '1' then
            word      <= word(POSITION_MAX + 6 downto 0) & sl_1;
            crc6      <= crc6_with;
            bits_left <= bits_left - 1;
            if bits_left = 1 then
              receiver  <= R_CRC;
              bits_left <= to_unsigned(6, 7);
            end if;
          end if;
        when R_CRC =>
          if sample = '1' then
            crc6      <= crc6_with;
            bits_left <= bits_left - 1;
            if bits_left = 1 then
              word_done  <= '1';
              word_slave <= slave;
              if with_life = '1' then
                word_position  <= word(POSITION_MAX + 7 downto 8);
                word_n_error   <= word(7);
                word_n_warning <= word(6);
                word_life      <= unsigned(word(5 downto 0));
              else
                word_position  <= word(POSITION_MAX + 1 downto 2);
                word_n_error   <= word(1);
                word_n_warning <= word(0);
                word_life      <= (others => '0');
              end if;
              word_crc_ok <= bit_of(crc6_with = "000000");
              slave       <= slave + 1;
              slaves_left <= slaves_left - 1;
              if slaves_left = 1 then
                receiver <= R_STOP;
              else
                receiver <= R_DATA;
              end if;
            end if;
          end if;
        when R_STOP =>
          if sample = '1' then
            receiver <= R_OFF;
          end if;
      end case;
      if ready then  -- for the data of the next encoder
        word          <= (others => '0');
        crc6          <= (others => '0');
        bits_left     <= data_bits;
        with_life     <= life_counters(0);
        positions     <= std_logic_vector(shift_right(unsigned(positions), 6));
        life_counters <= std_logic_vector(shift_right(unsigned(life_counters), 1));
      end if;
      if failed or reset = '1' then
        receiver <= R_OFF;
      end if;
    end if;
  end process;

  ------------------------------------------------------------------ registers
  -- step, the CDM of which frame is next:
  --   0 S   1 CTS   2..4 ID   5..11 ADR   12..15 ~CRC4   16 R   17 W   18 S   19..26 data
  --   27..30 ~CRC4   31 P   32 nothing, or S of one more
  -- CDS answers the CDM of the frame before. S that is not echoed in 19 is sent again: busy.
  checked <= fits = '1' when write = '1' else crc4 = "0000";

  process (clk)
    -- The access is over.
    procedure finish(result : std_logic_vector(2 downto 0)) is
    begin
      register_status <= result;
      register_done   <= '1';
      pending         <= '0';
      step            <= 0;
      zeros           <= 0;
    end procedure;
    -- A byte follows.
    procedure begin_byte(data : std_logic_vector(7 downto 0)) is
    begin
      cdm              <= '1';
      step             <= 19;
      sent             <= data & "000";
      crc4             <= "0000";
      fits             <= '1';
      start_us <= (others => '0');
    end procedure;
  begin
    if rising_edge(clk) then
      register_done <= '0';
      if us = '1' and start_us /= 32767 then
        start_us <= start_us + 1;
      end if;
      late <= start_us > BUSY_R_US;
      if register_start = '1' and pending = '0' then
        pending <= '1';
        write   <= register_write;
        id      <= register_id;
        sent    <= '1' & std_logic_vector(register_id) & register_address;
        rdata   <= register_wdata;
      end if;
      if whole then
        cdm <= '0';
        if step /= 32 then
          step <= step + 1;
        end if;
        if zeros /= ZEROS_MIN then
          zeros <= zeros + 1;
        end if;
        case step is
          when 0 =>
            if pending = '1' and zeros = ZEROS_MIN then
              cdm      <= '1';
              crc4     <= "0000";
              id_there <= '0';
            else
              step <= 0;
            end if;
          when 1 to 11 =>
            cdm  <= sent(10);
            sent <= sent(9 downto 0) & '0';
            crc4 <= crc4_next(crc4, sent(10));
            if step = to_integer(id) + 1 then
              id_there <= cds;
            end if;
          when 12 to 15 =>
            cdm  <= not crc4(3);
            crc4 <= crc4(2 downto 0) & '0';
          when 16 =>
            cdm <= not write;
          when 17 =>
            cdm    <= write;
            r_echo <= cds;
          when 18 =>
            if id_there = '0' or r_echo = write then
              finish(REGISTER_NO_ANSWER);
            elsif cds /= write then
              finish(REGISTER_REFUSED);
            else
              begin_byte(rdata);
            end if;
          when 19 =>
            if cds = '1' then
              cdm  <= write and sent(10);
              sent <= sent(9 downto 0) & '0';
              if write = '1' then
                crc4 <= crc4_next(crc4, sent(10));
              end if;
            elsif not late then
              cdm  <= '1';
              step <= 19;
            else
              finish(REGISTER_LATE);
            end if;
          when 20 to 26 =>
            cdm   <= write and sent(10);
            sent  <= sent(9 downto 0) & '0';
            fits  <= fits and (cds xnor cdm);
            rdata <= rdata(6 downto 0) & cds;
            if write = '1' then
              crc4 <= crc4_next(crc4, sent(10));
            else
              crc4 <= crc4_next(crc4, cds);
            end if;
          when 27 =>
            cdm   <= write and not crc4(3);
            fits  <= fits and (cds xnor cdm);
            rdata <= rdata(6 downto 0) & cds;
            if write = '1' then
              crc4 <= crc4(2 downto 0) & '0';
            else
              crc4 <= crc4_next(crc4, cds);
            end if;
          when 28 to 30 =>
            cdm  <= write and not crc4(3);
            fits <= fits and (cds xnor cdm);
            if write = '1' then
              crc4 <= crc4(2 downto 0) & '0';
            else
              crc4 <= crc4_next(crc4, not cds);
            end if;
          when 31 =>
            crc4 <= crc4_next(crc4, not cds);
            fits <= fits and (cds xnor cdm);
          when 32 =>  -- P
            if not checked then
              finish(REGISTER_CHECK);
            elsif cds = '1' then
              finish(REGISTER_REFUSED);
            elsif register_more = '1' then
              begin_byte(register_wdata);
              register_status <= REGISTER_OK;
              register_done   <= '1';
            else
              finish(REGISTER_OK);
            end if;
        end case;
      end if;
      if failed then  -- whether the frame ended in a CDM, and in which, is not known
        cdm   <= '0';
        zeros <= 0;
        step  <= 0;
        if pending = '1' then
          finish(REGISTER_LINE);
        end if;
      end if;
      if reset = '1' then
        pending <= '0';
        cdm     <= '0';
        zeros   <= 0;
        step    <= 0;
      end if;
    end if;
  end process;
end architecture;
