-- SPDX-License-Identifier: MIT
-- Pins, for tests that are the master themselves.
library ieee;
use ieee.std_logic_1164.all;

entity pins is
    port (
        ma, slo, sli : in std_logic;
        tx, rx, de : in std_logic
    );
end entity;

architecture none of pins is
begin
end architecture;
