-- SPDX-License-Identifier: MIT
-- What the models share, and what a test bench does to an instance by the name it has: turn("axis", 0.25). For GHDL
-- with any code generator (VHPIDIRECT), VHDL-2008. libdrehgeber_hdl.so has to be where the loader finds it.
library ieee;
use ieee.math_real.floor;
use ieee.std_logic_1164.all;

package drehgeber_hdl is
  -- The shaft is at so many turns, and rests; turns on with so many revolutions per minute; moves as words say, which
  -- are those of the generic MOTION.
  procedure turn(name : string; turns : real);
  procedure speed(name : string; rpm : real);
  procedure motion(name : string; words : string);
  -- A quantity of its world, in its unit: world("axis", "temperature", 125.0).
  procedure world(name : string; quantity : string; value : real);
  -- A fault happens, or is made good: drehgeber faults MODEL.
  procedure fault(name : string; which : string; on_off : boolean := true);
  procedure power(name : string; on_off : boolean);
  -- A line of SCPI, and what it answers in the first `length` characters.
  procedure command(name : string; line : string; answer : out string; length : out natural);
  -- What the latest frame has, when that was latched, and what a frame would have that is latched now: whole numbers.
  impure function latched(name : string) return real;
  impure function latched_at(name : string) return time;
  impure function position(name : string) return real;
  -- A position as bits.
  function to_bits(counts : real; width : positive) return std_logic_vector;

  -- For the models.
  subtype c_text is string(1 to 1024);
  function c(text : string) return c_text;
  impure function make(name, model, settings, moves, memory : string) return integer;
  impure function find(name : string) return integer;
  impure function look(id, inputs : integer) return integer;
  impure function rest(id : integer; most : time) return time;
  type reading is (is_position, is_latched, is_latched_at_us, is_sine, is_cosine);
  impure function read(id : integer; what : reading) return real;
  function delays(tco, delay_in, delay_out, jitter : real; seed : natural) return string;

  impure function dg_hdl_make(name, model, settings, moves, memory : c_text) return integer;
  attribute foreign of dg_hdl_make : function is "VHPIDIRECT libdrehgeber_hdl.so dg_hdl_make";
  impure function dg_hdl_find(name : c_text) return integer;
  attribute foreign of dg_hdl_find : function is "VHPIDIRECT libdrehgeber_hdl.so dg_hdl_find";
  impure function dg_hdl_look(id, us, ps, inputs : integer) return integer;
  attribute foreign of dg_hdl_look : function is "VHPIDIRECT libdrehgeber_hdl.so dg_hdl_look";
  impure function dg_hdl_rest(id, us, ps, most : integer) return integer;
  attribute foreign of dg_hdl_rest : function is "VHPIDIRECT libdrehgeber_hdl.so dg_hdl_rest";
  impure function dg_hdl_steer(id, us, ps, what : integer; text : c_text; value : real) return integer;
  attribute foreign of dg_hdl_steer : function is "VHPIDIRECT libdrehgeber_hdl.so dg_hdl_steer";
  impure function dg_hdl_character(id, which, index : integer) return integer;
  attribute foreign of dg_hdl_character : function is "VHPIDIRECT libdrehgeber_hdl.so dg_hdl_character";
  impure function dg_hdl_real(id, us, ps, what : integer) return real;
  attribute foreign of dg_hdl_real : function is "VHPIDIRECT libdrehgeber_hdl.so dg_hdl_real";
end package;

package body drehgeber_hdl is
  -- Foreign: these bodies are never run.
  impure function dg_hdl_make(name, model, settings, moves, memory : c_text) return integer is
  begin
    assert false severity failure;
  end function;
  impure function dg_hdl_find(name : c_text) return integer is
  begin
    assert false severity failure;
  end function;
  impure function dg_hdl_look(id, us, ps, inputs : integer) return integer is
  begin
    assert false severity failure;
  end function;
  impure function dg_hdl_rest(id, us, ps, most : integer) return integer is
  begin
    assert false severity failure;
  end function;
  impure function dg_hdl_steer(id, us, ps, what : integer; text : c_text; value : real) return integer is
  begin
    assert false severity failure;
  end function;
  impure function dg_hdl_character(id, which, index : integer) return integer is
  begin
    assert false severity failure;
  end function;
  impure function dg_hdl_real(id, us, ps, what : integer) return real is
  begin
    assert false severity failure;
  end function;

  type steering is (by_turn, by_speed, by_motion, by_world, by_fault, by_power, by_command);

  function c(text : string) return c_text is
    variable result : c_text := (others => nul);
  begin
    assert text'length < result'length report "drehgeber: a text is too long: " & text severity failure;
    result(1 to text'length) := text;
    return result;
  end function;

  function us_of(t : time) return integer is
  begin
    return t / 1 us;
  end function;

  function ps_of(t : time) return integer is
  begin
    return (t - (t / 1 us) * 1 us) / 1 ps;
  end function;

  -- Which text of an encoder to read: enum dg_hdl_text.
  type texts is (the_answer, the_error, the_hint);

  procedure read_text(id : integer; which : texts; text : out string; length : out natural) is
    variable code : integer;
    variable n    : natural := 0;
  begin
    while n < text'length loop
      code := dg_hdl_character(id, texts'pos(which), n);
      exit when code = 0;
      text(text'left + n) := character'val(code);
      n := n + 1;
    end loop;
    length := n;
  end procedure;

  procedure complain(name : string; id : integer) is
    variable text   : string(1 to 2048);
    variable length : natural;
  begin
    read_text(id, the_error, text, length);
    if length > 0 then
      report name & ": " & text(1 to length) severity failure;
    end if;
  end procedure;

  impure function find(name : string) return integer is
    variable id : integer;
  begin
    id := dg_hdl_find(c(name));
    assert id >= 0 report "drehgeber: there is no encoder '" & name & "', or not yet" severity failure;
    return id;
  end function;

  impure function make(name, model, settings, moves, memory : string) return integer is
    variable id : integer;
  begin
    id := dg_hdl_make(c(name), c(model), c(settings), c(moves), c(memory));
    assert id /= -2 report "drehgeber: two encoders have the name '" & name & "'" severity failure;
    assert id >= 0 report "drehgeber: no memory for an encoder" severity failure;
    complain(name, id);
    return id;
  end function;

  impure function look(id, inputs : integer) return integer is
    constant levels : integer := dg_hdl_look(id, us_of(now), ps_of(now), inputs);
    variable text   : string(1 to 2048);
    variable length : natural;
  begin
    if levels >= 256 then
      read_text(id, the_hint, text, length);
      report text(1 to length);
    end if;
    return levels mod 256;
  end function;

  impure function rest(id : integer; most : time) return time is
  begin
    return dg_hdl_rest(id, us_of(now), ps_of(now), most / 1 ps) * 1 ps;
  end function;

  impure function read(id : integer; what : reading) return real is
  begin
    return dg_hdl_real(id, us_of(now), ps_of(now), reading'pos(what));
  end function;

  function delays(tco, delay_in, delay_out, jitter : real; seed : natural) return string is
    function ns(value : real) return string is
      constant ps    : integer := integer(value * 1000.0);
      constant parts : string  := integer'image(ps mod 1000 + 1000);
    begin
      return integer'image(ps / 1000) & "." & parts(2 to 4);
    end function;
  begin
    return "tco_ns=" & ns(tco) & " delay_in_ns=" & ns(delay_in) & " delay_out_ns=" & ns(delay_out) &
      " jitter_ns=" & ns(jitter) & " seed=" & integer'image(seed) & " ";
  end function;

  procedure steer(name : string; what : steering; text : string; value : real) is
    variable id : integer;
  begin
    id := find(name);
    if dg_hdl_steer(id, us_of(now), ps_of(now), steering'pos(what), c(text), value) < 0 then
      complain(name, id);
    end if;
  end procedure;

  function to_real(value : boolean) return real is
  begin
    if value then
      return 1.0;
    end if;
    return 0.0;
  end function;

  procedure turn(name : string; turns : real) is
  begin
    steer(name, by_turn, "", turns);
  end procedure;

  procedure speed(name : string; rpm : real) is
  begin
    steer(name, by_speed, "", rpm);
  end procedure;

  procedure motion(name : string; words : string) is
  begin
    steer(name, by_motion, words, 0.0);
  end procedure;

  procedure world(name : string; quantity : string; value : real) is
  begin
    steer(name, by_world, quantity, value);
  end procedure;

  procedure fault(name : string; which : string; on_off : boolean := true) is
  begin
    steer(name, by_fault, which, to_real(on_off));
  end procedure;

  procedure power(name : string; on_off : boolean) is
  begin
    steer(name, by_power, "", to_real(on_off));
  end procedure;

  procedure command(name : string; line : string; answer : out string; length : out natural) is
  begin
    steer(name, by_command, line, 0.0);
    read_text(find(name), the_answer, answer, length);
  end procedure;

  impure function latched(name : string) return real is
  begin
    return read(find(name), is_latched);
  end function;

  impure function latched_at(name : string) return time is
  begin
    return read(find(name), is_latched_at_us) * 1 us;
  end function;

  impure function position(name : string) return real is
  begin
    return read(find(name), is_position);
  end function;

  function to_bits(counts : real; width : positive) return std_logic_vector is
    variable left : real := counts;
    variable half : real;
    variable bits : std_logic_vector(width - 1 downto 0);
  begin
    for i in 0 to width - 1 loop
      half := floor(left / 2.0); -- real numbers have 53 bits, integers 32
      bits(i) := '1' when left - 2.0 * half > 0.5 else '0';
      left := half;
    end loop;
    return bits;
  end function;
end package body;
