-- SPDX-License-Identifier: MIT
-- An encoder with BiSS-C: one instance, one encoder, with a name for the procedures of drehgeber_hdl.vhd.
--
--   encoder : entity work.drehgeber_biss
--     generic map (NAME => "axis", SETTINGS => "busy_us=5 busy_jitter_us=3") port map (ma => ma, slo => slo);
--
-- A chain: slo of the next encoder goes into sli; the last one has '0' there. MA that is neither 0 nor 1 counts as 1.
library ieee;
use ieee.std_logic_1164.all;
use work.drehgeber_hdl.all;

entity drehgeber_biss is
  generic (
    NAME           : string  := "encoder";      -- unique in a simulation
    MODEL          : string  := "s3684-biss";   -- drehgeber list
    SETTINGS       : string  := "";             -- KEY=VALUE KEY=VALUE: drehgeber run MODEL --help
    MOTION         : string  := "";             -- 90DEG, 60RPM, sine:90DEG,2S, ramp:3000RPM,1S, FILE.csv
    MEMORY         : string  := "";             -- file of the EEPROM
    TCO_NS         : real    := 10.0;           -- from an edge of MA at the encoder to SLO; above 0
    MA_DELAY_NS    : real    := 0.0;            -- of the cable to the encoder
    SLO_DELAY_NS   : real    := 0.0;            -- of the cable from the encoder
    JITTER_NS      : real    := 0.0;            -- up to as much more, for each edge either way
    SEED           : natural := 1;              -- of jitter and chance
    POLL           : time    := 1 us            -- how late SLO may follow a procedure, power() for one; at most 1 ms
  );
  port (
    ma  : in  std_logic;
    sli : in  std_logic := '0';
    slo : out std_logic
  );
end entity;

architecture simulated of drehgeber_biss is
begin
  process
    variable id     : integer;
    variable levels : integer;
    impure function inputs return integer is
      variable result : integer := 0;
    begin
      if to_x01(ma) /= '0' then
        result := 1;
      end if;
      if to_x01(sli) = '1' then
        result := result + 2;
      end if;
      return result;
    end function;
  begin
    id := make(NAME, MODEL, delays(TCO_NS, MA_DELAY_NS, SLO_DELAY_NS, JITTER_NS, SEED) & SETTINGS, MOTION, MEMORY);
    loop
      levels := look(id, inputs);
      slo <= '1' when levels mod 2 = 1 else '0';
      wait on ma, sli for rest(id, POLL);
    end loop;
  end process;
end architecture;
