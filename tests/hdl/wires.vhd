-- SPDX-License-Identifier: MIT
-- The masters in VHDL and the models for GHDL: positions and a register on one wire. Generics are the wire; what is
-- expected is worked out from the angle. See wires.v, which does the same.
library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;
use ieee.math_real.all;
use std.env.finish;
use work.drehgeber_hdl.all;

entity wires is
  generic (
    CLOCK_NS : positive := 10;           -- of the masters
    HALF     : positive := 5;            -- half a period of MA, in clocks
    CABLE_NS : natural  := 10;           -- each way
    SETTINGS : string   := "busy_us=3";
    CHAIN    : positive := 1;
    SEED     : positive := 1;
    FRAMES   : positive := 4
  );
end entity;

architecture bench of wires is
  constant DELAY_NS : real := real(CABLE_NS);

  signal clk      : std_logic := '0';
  signal reset    : std_logic := '1';

  -- BiSS: MT 12 and ST 21 in each slot
  signal cycle, start, write : std_logic := '0';
  signal id       : unsigned(2 downto 0) := "000";
  signal address  : std_logic_vector(6 downto 0) := (others => '0');
  signal wdata    : std_logic_vector(7 downto 0) := (others => '0');
  signal ma, done, frame_done, word_done, n_error, n_warning, crc_ok : std_logic;
  signal frame_status, status : std_logic_vector(2 downto 0);
  signal slave    : unsigned(2 downto 0);
  signal position : std_logic_vector(47 downto 0);
  signal life     : unsigned(5 downto 0);
  signal rdata    : std_logic_vector(7 downto 0);
  signal slo, sli : std_logic_vector(2 downto 0);

  type expectations is array (0 to 2) of unsigned(32 downto 0);  -- of 4096 turns of 2^21
  signal expected : expectations := (others => (others => '0'));
  signal checks   : natural := 0;
  signal bent     : boolean := false;  -- by a fault: words that are wrong are counted
  signal wrong    : natural := 0;      -- since then, of the encoder next to the master

  -- SSI: 25 bits in Gray code
  signal ssi_cycle, clock, data, ssi_done : std_logic := '0';
  signal ssi_status   : std_logic_vector(1 downto 0);
  signal ssi_position : std_logic_vector(33 downto 0);
  signal clock_half   : unsigned(11 downto 0);
begin
  clk <= not clk after CLOCK_NS * 500 ps;

  master : entity work.biss_master
    generic map (CLK_HZ => 1000000000 / CLOCK_NS, SLAVES => 3)
    port map (
      clk => clk, reset => reset, ma_half => to_unsigned(HALF, 12), slave_count => to_unsigned(CHAIN, 4),
      position_bits => "100001100001100001", life_counter => "111", cycle => cycle, latch => open,
      frame_done => frame_done, frame_status => frame_status, line_delay => open, word_done => word_done,
      word_slave => slave, word_position => position, word_n_error => n_error, word_n_warning => n_warning,
      word_life => life, word_crc_ok => crc_ok, register_start => start, register_write => write, register_id => id,
      register_address => address, register_wdata => wdata, register_more => '0', register_busy => open,
      register_done => done, register_rdata => rdata, register_status => status, ma => ma, sl => slo(0));

  sli(0) <= slo(1) when CHAIN > 1 else '0';
  sli(1) <= slo(2) when CHAIN > 2 else '0';
  sli(2) <= '0';
  encoders : for i in 0 to 2 generate
    encoder : entity work.drehgeber_biss
      generic map (NAME => "biss" & integer'image(i), SETTINGS => SETTINGS, MA_DELAY_NS => DELAY_NS,
                   SLO_DELAY_NS => DELAY_NS * real(1 - (i + 1) / 2), JITTER_NS => 2.0 * real(1 - (i + 1) / 2))
      port map (ma => ma, sli => sli(i), slo => slo(i));
  end generate;

  clock_half <= to_unsigned(maximum(250 / CLOCK_NS, HALF), 12);
  ssi : entity work.ssi_master
    generic map (CLK_HZ => 1000000000 / CLOCK_NS)
    port map (
      clk => clk, reset => reset, clock_half => clock_half, sample_delay => to_unsigned(400 / CLOCK_NS, 12),
      pause_us => to_unsigned(22, 8), position_bits => to_unsigned(25, 6), gray => '1', has_error => '0',
      has_parity => '0', parity_odd => '0', cycle => ssi_cycle, latch => open, done => ssi_done, status => ssi_status,
      word => open, position => ssi_position, error => open, parity_ok => open, clock => clock, data => data);
  ssi_encoder : entity work.drehgeber_ssi
    generic map (NAME => "ssi", MODEL => "ssi-25", CLOCK_DELAY_NS => DELAY_NS, DATA_DELAY_NS => DELAY_NS)
    port map (clock => clock, data => data);

  -- What comes from BiSS.
  process (clk)
    variable words, count : natural := 0;
    variable lc           : natural := 0;
  begin
    if falling_edge(clk) then
      if not bent then
        wrong <= 0;
      elsif word_done = '1' and crc_ok = '0' then
        assert slave = 0 report "slave with a wrong CRC" severity failure;
        wrong <= wrong + 1;
      end if;
      if word_done = '1' and not bent then
        assert slave = words report "slave " & integer'image(to_integer(slave)) severity failure;
        assert crc_ok = '1' and n_error = '1' and n_warning = '1' report "CRC, nERR or nWARN" severity failure;
        assert unsigned(position) = expected(words) report "position" severity failure;
        -- 0 once, in the first frame.
        assert life = lc report "LC " & integer'image(to_integer(life)) severity failure;
        words := words + 1;
        count := count + 4;
      end if;
      if frame_done = '1' then
        assert bent or (frame_status = "000" and words = CHAIN) report "frame" severity failure;
        words := 0;
        lc    := lc + 1;
        if lc = 64 then
          lc := 1;
        end if;
        count := count + 1;
      end if;
      checks <= count;
    end if;
  end process;

  process
    variable seed_1 : positive := SEED;
    variable seed_2 : positive := 1;
    variable random : real;
    variable steps  : integer;
    variable more   : natural := 0;
    variable wanted : signed(31 downto 0);
    constant QUARTER : unsigned(24 downto 0) := 25x"800";  -- of a turn
    constant ANOTHER : unsigned(24 downto 0) := (others => '1');  -- than that

    -- In steps of 2^-18 turns, from -4096 to 4096 turns.
    procedure next_steps is
    begin
      uniform(seed_1, seed_2, random);
      steps := integer(floor(random * 2147483647.0)) - 1073741824;
    end procedure;

    procedure frame is
    begin
      wait until falling_edge(clk);
      cycle <= '1';
      wait until falling_edge(clk) and frame_done = '1';
      cycle <= '0';
    end procedure;

    -- Frames with a fault behind the first encoder's driver, and one without.
    procedure bent_frames(name : string; wanted : std_logic_vector(2 downto 0); count, wanted_wrong : natural) is
    begin
      fault("biss0", name);
      if name = "wire_break" then
        wait for 2 us;  -- as late as the model may follow
        assert slo(0) = '1' report "SLO that is cut" severity failure;
      end if;
      bent <= true;
      for i in 1 to count loop
        frame;
        assert frame_status = wanted report name & ": status" severity failure;
      end loop;
      wait until falling_edge(clk);
      assert wrong = wanted_wrong report name & ": " & integer'image(wrong) & " wrong words" severity failure;
      fault("biss0", name, false);
      wait for 2 us;
      bent <= false;
      more := more + count + 1;
      frame;
    end procedure;

    procedure ssi_word(wanted_status : std_logic_vector(1 downto 0)) is
    begin
      wait until falling_edge(clk);
      ssi_cycle <= '1';
      wait until falling_edge(clk) and ssi_done = '1';
      ssi_cycle <= '0';
      assert ssi_status = wanted_status report "SSI status" severity failure;
      more := more + 1;
    end procedure;

    procedure ssi_is(wanted : unsigned(24 downto 0); what : string) is
    begin
      assert unsigned(ssi_position(24 downto 0)) = wanted or
          (wanted = ANOTHER and unsigned(ssi_position(24 downto 0)) /= QUARTER)
        report "SSI position, " & what & ": " & to_hstring(ssi_position(24 downto 0)) severity failure;
      more := more + 1;
    end procedure;

    -- A word with a fault, and the one behind it.
    procedure ssi_bent(name : string; wanted_status : std_logic_vector(1 downto 0); wanted : unsigned(24 downto 0)) is
    begin
      fault("ssi", name);
      wait for 2 us;
      ssi_word(wanted_status);
      if wanted_status = "00" then
        ssi_is(wanted, name);
      end if;
      fault("ssi", name, false);
      wait for 2 us;
      ssi_word("00");
      ssi_is(QUARTER, "behind " & name);
    end procedure;

    procedure access_register(w : std_logic; slave_id : natural; at, to_write, there : std_logic_vector) is
    begin
      wait until falling_edge(clk);
      cycle   <= '1';
      start   <= '1';
      write   <= w;
      id      <= to_unsigned(slave_id, 3);
      address <= at;
      wdata   <= to_write;
      wait until falling_edge(clk);
      start <= '0';
      wait until falling_edge(clk) and done = '1';
      assert status = "000" and rdata = there report "register" severity failure;
      more := more + 1;
      wait until falling_edge(clk) and frame_done = '1';
      cycle <= '0';
    end procedure;
  begin
    wait for 20 ns; -- power comes after 1 ns, and the line follows after 10
    assert slo(0) = '0' report "SLO before the first pulse" severity failure;
    wait for 200 ns;
    reset <= '0';
    for i in 1 to FRAMES loop
      for j in 0 to 2 loop
        next_steps;
        expected(j) <= unsigned(shift_left(resize(to_signed(steps, 33), 33), 3));
        turn("biss" & integer'image(j), real(steps) / 262144.0);
      end loop;
      frame;
    end loop;
    -- ID 0 is the last one.
    if SEED mod 2 = 0 then
      access_register('0', 0, "1111110", "00000000", "01001011");
    else
      access_register('1', CHAIN - 1, "0100010", "10100101", "10100101");
    end if;
    bent_frames("wire_drop", "001", 1, 0);
    bent_frames("wire_delay", "010", 1, 0);
    bent_frames("wire_damage", "000", 4, 4);
    bent_frames("wire_break", "001", 1, 0);
    for i in 1 to 4 loop
      next_steps;
      turn("ssi", real(steps) / 262144.0);
      ssi_word("00");
      wanted := to_signed(steps, 32);
      -- 12 bits of turns, 13 of the turn: 18 - 13 are too fine.
      ssi_is(unsigned(wanted(29 downto 5)), "at random");
    end loop;
    turn("ssi", 0.25);
    ssi_bent("wire_drop", "00", to_unsigned(0, 25));
    if HALF * CLOCK_NS < 500 then  -- a microsecond is two clocks
      ssi_bent("wire_delay", "00", 25x"1000200");
    else
      ssi_bent("wire_delay", "00", 25x"1FFFBFF");
    end if;
    for i in 1 to 4 loop
      ssi_bent("wire_damage", "00", ANOTHER);
    end loop;
    ssi_bent("wire_break", "01", ANOTHER);
    assert checks > 0 report "nothing was looked at" severity failure;
    report "passed " & integer'image(checks + more) & " checks in " & integer'image(now / 1 us) & " us";
    finish;  -- the encoders look at their lines without end
  end process;
end architecture;
