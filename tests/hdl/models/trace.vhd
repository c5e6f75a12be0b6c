-- SPDX-License-Identifier: MIT
-- As trace.sv.
library ieee;
use ieee.std_logic_1164.all;
use std.textio.all;
use work.drehgeber_hdl.all;

entity trace is
end entity;

architecture test of trace is
  constant JITTERY : string := "busy_us=2 busy_jitter_us=9";
  signal ma, clock, rx                           : std_logic := '1';
  signal a, b, c, near, behind, data, tx, de     : std_logic;

  procedure tell(name : string; level : std_logic) is
    variable text : line;
  begin
    write(text, name & " " & integer'image(now / 1 us) & " " & integer'image((now - now / 1 us * 1 us) / 1 ps) & " ");
    write(text, std_logic'image(level)(2));
    writeline(output, text);
  end procedure;
begin
  of_a : entity work.drehgeber_biss
    generic map (NAME => "a", SETTINGS => JITTERY, JITTER_NS => 4.0, MA_DELAY_NS => 12.5, SLO_DELAY_NS => 33.3,
                 SEED => 7, MOTION => "600RPM", POLL => 100 ns)
    port map (ma => ma, slo => a);
  of_b : entity work.drehgeber_biss
    generic map (NAME => "b", SETTINGS => JITTERY, JITTER_NS => 4.0, MA_DELAY_NS => 12.5, SLO_DELAY_NS => 33.3,
                 SEED => 7, MOTION => "600RPM")
    port map (ma => ma, slo => b);
  of_c : entity work.drehgeber_biss
    generic map (NAME => "c", SETTINGS => JITTERY, JITTER_NS => 4.0, MA_DELAY_NS => 12.5, SLO_DELAY_NS => 33.3,
                 SEED => 8, MOTION => "600RPM")
    port map (ma => ma, slo => c);
  of_near : entity work.drehgeber_biss
    generic map (NAME => "near", MOTION => "90DEG")
    port map (ma => ma, sli => behind, slo => near);
  of_behind : entity work.drehgeber_biss
    generic map (NAME => "behind", MODEL => "s3674-biss", MOTION => "45DEG", TCO_NS => 7.25)
    port map (ma => ma, slo => behind);
  of_data : entity work.drehgeber_ssi
    generic map (NAME => "data", MOTION => "90DEG")
    port map (clock => clock, data => data);
  of_tx : entity work.drehgeber_rs485
    generic map (NAME => "tx", SINCOS => 0 ns)
    port map (rx => rx, tx => tx, de => de);

  process (a)
  begin
    tell("a", a);
  end process;
  process (b)
  begin
    tell("b", b);
  end process;
  process (c)
  begin
    tell("c", c);
  end process;
  process (near)
  begin
    tell("near", near);
  end process;
  process (behind)
  begin
    tell("behind", behind);
  end process;
  process (data)
  begin
    tell("data", data);
  end process;
  process (tx)
  begin
    tell("tx", tx);
  end process;
  process (de)
  begin
    tell("de", de);
  end process;

  process
    procedure put(character : std_logic_vector(7 downto 0)) is
    begin
      rx <= '0';
      wait for 104166 ns;
      for i in 0 to 7 loop
        rx <= character(i);
        wait for 104166 ns;
      end loop;
      rx <= xor character;
      wait for 104166 ns;
      rx <= '1';
      wait for 104166 ns;
    end procedure;
  begin
    wait for 1000 ns;
    for i in 0 to 3 loop
      for k in 0 to 149 loop
        wait for 250 ns;
        ma <= '0';
        wait for 250 ns;
        ma <= '1';
      end loop;
      wait for 20000 ns;
      turn("near", 0.125 * real(i));
      if i = 1 then
        fault("behind", "led_current_high", true);
      end if;
      if i = 2 then
        power("near", false);
      end if;
    end loop;
    for k in 0 to 25 loop
      wait for 500 ns;
      clock <= '0';
      wait for 500 ns;
      clock <= '1';
    end loop;
    put(x"40");
    put(x"42");
    put(x"02");
    wait for 20 ms;
    power("tx", false);
    wait for 1000 ns;
    write(output, "done" & LF);
    std.env.finish;
  end process;
end architecture;
