-- SPDX-License-Identifier: MIT
-- An encoder with RS485 and SinCos: one instance, one encoder, with a name for the procedures of drehgeber_hdl.vhd.
--
--   encoder : entity work.drehgeber_rs485
--     generic map (NAME => "axis") port map (rx => to_encoder, tx => from_encoder, de => drives);
--
-- rx is what the master sends, tx what the encoder sends while its driver is enabled, de; both are 1 in between. Data
-- rate and parity are those that the encoder has at the moment. sine and cosine are the differences sin+ - sin- and
-- cos+ - cos- in volts, of the same shaft as the position that 42h gives; renewed every SINCOS.
library ieee;
use ieee.std_logic_1164.all;
use work.drehgeber_hdl.all;

entity drehgeber_rs485 is
  generic (
    NAME           : string  := "encoder";      -- unique in a simulation
    MODEL          : string  := "s3684-rs485";  -- drehgeber list
    SETTINGS       : string  := "";             -- KEY=VALUE KEY=VALUE: drehgeber run MODEL --help
    MOTION         : string  := "";             -- 90DEG, 60RPM, sine:90DEG,2S, ramp:3000RPM,1S, FILE.csv
    MEMORY         : string  := "";             -- file of the EEPROM
    TCO_NS         : real    := 10.0;           -- from a bit at the encoder to tx; above 0
    RX_DELAY_NS    : real    := 0.0;            -- of the cable to the encoder
    TX_DELAY_NS    : real    := 0.0;            -- of the cable from the encoder
    JITTER_NS      : real    := 0.0;            -- up to as much more, for each edge either way
    SEED           : natural := 1;              -- of jitter and chance
    POLL           : time    := 1 us;           -- how late tx may follow a procedure, power() for one; at most 1 ms
    SINCOS         : time    := 1 us            -- how often sine and cosine are renewed; 0 ns: never
  );
  port (
    rx     : in  std_logic;
    tx     : out std_logic := '1';
    de     : out std_logic := '0';
    sine   : out real := 0.0;
    cosine : out real := 0.0
  );
end entity;

architecture simulated of drehgeber_rs485 is
begin
  process
    variable id     : integer;
    variable levels : integer;
    impure function inputs return integer is
    begin
      if to_x01(rx) = '0' then
        return 0;
      end if;
      return 1;
    end function;
  begin
    id := make(NAME, MODEL, delays(TCO_NS, RX_DELAY_NS, TX_DELAY_NS, JITTER_NS, SEED) & SETTINGS, MOTION, MEMORY);
    loop
      levels := look(id, inputs);
      tx <= '1' when levels mod 2 = 1 else '0';
      de <= '1' when levels / 2 mod 2 = 1 else '0';
      wait on rx for rest(id, POLL);
    end loop;
  end process;

  process
    variable id : integer;
  begin
    if SINCOS = 0 ns then
      wait;
    end if;
    wait for SINCOS;
    id := find(NAME);
    sine   <= read(id, is_sine);
    cosine <= read(id, is_cosine);
  end process;
end architecture;
