-- SPDX-License-Identifier: MIT
-- An encoder with SSI: one instance, one encoder, with a name for the procedures of drehgeber_hdl.vhd.
--
--   encoder : entity work.drehgeber_ssi
--     generic map (NAME => "axis", SETTINGS => "mt=12 st=13") port map (clock => clock, data => data);
--
-- A clock that is neither 0 nor 1 counts as 1.
library ieee;
use ieee.std_logic_1164.all;
use work.drehgeber_hdl.all;

entity drehgeber_ssi is
  generic (
    NAME           : string  := "encoder";      -- unique in a simulation
    MODEL          : string  := "ssi-25";       -- drehgeber list
    SETTINGS       : string  := "";             -- KEY=VALUE KEY=VALUE: drehgeber run MODEL --help
    MOTION         : string  := "";             -- 90DEG, 60RPM, sine:90DEG,2S, ramp:3000RPM,1S, FILE.csv
    MEMORY         : string  := "";             -- file of the EEPROM
    TCO_NS         : real    := 150.0;          -- from an edge of the clock at the encoder to data; above 0
    CLOCK_DELAY_NS : real    := 0.0;            -- of the cable to the encoder
    DATA_DELAY_NS  : real    := 0.0;            -- of the cable from the encoder
    JITTER_NS      : real    := 0.0;            -- up to as much more, for each edge either way
    SEED           : natural := 1;              -- of jitter and chance
    POLL           : time    := 1 us            -- how late data may follow a procedure, power() for one; at most 1 ms
  );
  port (
    clock : in  std_logic;
    data  : out std_logic
  );
end entity;

architecture simulated of drehgeber_ssi is
begin
  process
    variable id     : integer;
    variable levels : integer;
    impure function inputs return integer is
    begin
      if to_x01(clock) = '0' then
        return 0;
      end if;
      return 1;
    end function;
  begin
    id := make(NAME, MODEL, delays(TCO_NS, CLOCK_DELAY_NS, DATA_DELAY_NS, JITTER_NS, SEED) & SETTINGS, MOTION, MEMORY);
    loop
      levels := look(id, inputs);
      data <= '1' when levels mod 2 = 1 else '0';
      wait on clock for rest(id, POLL);
    end loop;
  end process;
end architecture;
