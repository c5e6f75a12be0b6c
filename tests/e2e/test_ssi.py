# SPDX-License-Identifier: MIT
"""SSI behind its simulated wire: `drehgeber ssi`, `run --sim`, SCPI, rig files; traces are read by sigrok
and by a decoder that is written from the public descriptions alone."""
import re
import subprocess
import time

import pytest

from rig import Client, Encoder, run, run_refused, start_rig

S13, S25, S28 = "ssi-13", "ssi-25", "ssi-28"
BITS = {S13: 13, S25: 25, S28: 30}
CLOCK, DATA = "m", "s"


def ssi(*arguments) -> str:
    ended = run("ssi", *arguments)
    assert ended.returncode == 0 and ended.stderr == "", ended.stderr
    return ended.stdout


def changes(trace: str, signal: str) -> list:
    """(ns, level) of a signal."""
    now, found = 0, []
    for line in trace.splitlines():
        if line.startswith("#"):
            now = int(line[1:]) * 10
        elif re.fullmatch(rf"[01]{signal}", line):
            found.append((now, line[0]))
    return found


def words(trace: str, pause_ns: int = 15000) -> list:
    """Data at each falling edge of the clock: a 1, the word, and a 0 behind it are clocked; the 0 has no
    falling edge behind it in a single word."""
    data = changes(trace, DATA)
    found, last = [], None
    for moment, level in changes(trace, CLOCK):
        if level == "1":
            continue
        if last is None or moment - last > pause_ns:
            found.append("")
        last = moment
        found[-1] += [to for at, to in data if at <= moment][-1]
    return found


def binary(gray: str) -> int:
    value = 0
    for bit in gray:
        value = value << 1 | (value & 1) ^ int(bit)
    return value


def position(model: str, word: str) -> tuple:
    """Position, error bit; parity is right."""
    assert word[0] == "1" and len(word) == BITS[model] + 1
    word = word[1:]
    if model != S28:
        return binary(word), 0
    assert word.count("1") % 2 == 0
    return int(word[:28], 2), int(word[28])


def sigrok(trace, bits: int) -> list:
    """What sigrok's SPI decoder makes of CLOCK and DATA: samples at falling edges, in words."""
    decoder = f"spi:clk=CLOCK:miso=DATA:cpol=1:cpha=0:wordsize={bits}"
    ended = subprocess.run(
        ["sigrok-cli", "-i", str(trace), "-I", "vcd", "-P", decoder, "-A", "spi=miso-data"],
        capture_output=True, text=True, timeout=60, check=True)
    return [int(line.split()[-1], 16) for line in ended.stdout.splitlines()]


@pytest.mark.parametrize("model, shaft, said", [
    (S13, "90DEG", "MT 0  ST 2048  90.000000 deg\n"),
    (S25, "2.5REV", "MT 2  ST 4096  180.000000 deg\n"),
    (S28, "-0.25REV", "MT 4095  ST 49152  270.000000 deg  error 0  parity valid\n"),
])
def test_position_follows_the_shaft(model, shaft, said):
    assert ssi(model, "read", f"--shaft={shaft}") == said
    assert ssi(model, "read", "read", f"--shaft={shaft}") == said * 2


def test_words_of_a_trace(tmp_path):
    """Every level as the descriptions say; two words of a shaft that turns."""
    trace = tmp_path / "ssi.vcd"
    for model, counts in (S13, 8192), (S25, 8192), (S28, 65536):
        for eighth in range(8):
            angle = 360 * 3 + 45 * eighth
            ssi(model, "read", "read", "--shaft", f"{angle}DEG", "--trace", trace)
            text = trace.read_text()
            wanted = angle * counts // 360 % (counts if model == S13 else counts * 4096)
            assert [position(model, word) for word in words(text)] == [(wanted, 0)] * 2
            assert "position_" in text
            clock = changes(text, CLOCK)
            # Data moves on rising edges of the clock, and when the monoflop time is over.
            rising = {at for at, level in clock if level == "1"}
            falling = [at for at, level in clock[1:] if level == "0"]
            ends = {at + 20000 for at in falling}
            assert {at for at, _ in changes(text, DATA)[1:]} <= rising | ends
            assert clock[-1][1] == "1" and changes(text, DATA)[-1][1] == "1"


@pytest.mark.parametrize("model", [S13, S25, S28])
def test_sigrok_reads_the_trace(tmp_path, model):
    trace = tmp_path / "ssi.vcd"
    ssi(model, *["read"] * 3, "--shaft", "3.25REV", "--trace", trace)
    turns = 0 if model == S13 else 3
    counts = 65536 if model == S28 else 8192
    wanted = turns * counts + counts // 4
    read = sigrok(trace, BITS[model] + 1)
    assert len(read) == 3
    for word in read:
        assert position(model, f"{word:0{BITS[model] + 1}b}") == (wanted, 0)


@pytest.mark.parametrize("settings, bits, what", [
    ("mt=12 st=12 code=binary", 24, "MT 1  ST 1024  90.000000 deg\n"),
    ("mt=0 st=10", 10, "MT 0  ST 256  90.000000 deg\n"),
    ("mt=16 st=16 error_bit=low parity=odd", 34, "MT 1  ST 16384  90.000000 deg  error 0  parity valid\n"),
    ("once=1 monoflop_us=30", 25, "MT 1  ST 2048  90.000000 deg\n"),
])
def test_settings(tmp_path, settings, bits, what):
    trace = tmp_path / "ssi.vcd"
    sets = [word for setting in settings.split() for word in ("--set", setting)]
    assert ssi(S25, "read", "--shaft", "1.25REV", "--trace", trace, *sets) == what
    (word,) = words(trace.read_text())
    assert len(word) == bits + 1
    if "odd" in settings:
        assert word[1:].count("1") % 2 == 1 and word[-2] == "1"


@pytest.mark.parametrize("arguments, right", [
    (["--set", "code=grey"], r"code=grey.*expected gray or binary"),
    (["--set", "parity=mark"], r"parity=mark.*expected none, even or odd"),
    (["--set", "error_bit=1"], r"error_bit=1.*expected none, high or low"),
    (["--set", "st=33"], r"st=33.*1\.\.32"),
    (["--set", "st=32"], r"mt 0 and st 32; expected 10 to 32 bits together, mt 0\.\.24 and st 8\.\.31"),
    (["--set", "mt=24"], r"mt 24 and st 13; expected 10 to 32 bits together"),
    (["--set", "monoflop_us=9"], r"monoflop_us=9.*10\.\.1000000 us"),
    (["--serial", "5"], r"--serial 5: ssi-13 has none; leave it out"),
    (["--nvm", "x.nvm"], r"--nvm.*ssi-13 has no EEPROM; leave it out"),
    (["--set", "lc=1"], r"lc.*no such key; valid: mt st code error_bit parity once monoflop_us init_ms "),
])
def test_what_is_wrong_is_said_alike(tmp_path, arguments, right):
    for command in ["ssi", S13, "read"], ["run", S13]:
        assert re.search(right, run_refused(2, *command, *arguments, cwd=tmp_path))


def test_refusals(tmp_path):
    assert "valid: ssi-13 ssi-25 ssi-28" in run_refused(2, "ssi", "s3674-biss", "read")
    assert "expected read" in run_refused(2, "ssi", S13)
    assert "expected read" in run_refused(2, "ssi", S13, "fly")
    assert "--sim or --gpio" in run_refused(2, "run", S13, "--pty")
    assert "SSI ends in .vcd" in run_refused(2, "ssi", S13, "read", "--trace", tmp_path / "a.log")


SLOW = [  # clock, monoflop time; the lowest clock and time: a period has to be shorter
    ((50000, 20), (50003, 21)), ((50002, 20), (50003, 21)), ((99999, 10), (100011, 11)), ((100010, 10), (100011, 11))]


@pytest.mark.parametrize("given, lowest", SLOW)
def test_a_clock_that_ends_the_word_is_refused(given, lowest):
    def words_of(clock_hz, monoflop_us):
        return "--shaft", "90DEG", "--set", f"clock_hz={clock_hz}", "--set", f"monoflop_us={monoflop_us}"

    for how in (("ssi", S25, "read"), ("run", S25, "--sim")):
        said = run_refused(2, *how, *words_of(*given))
        assert f"--set clock_hz={given[0]}: its period" in said
        assert f"expected clock_hz from {lowest[0]} or monoflop_us from {lowest[1]} on" in said
    for right in ((lowest[0], given[1]), (given[0], lowest[1])):
        assert ssi(S25, *["read"] * 20, *words_of(*right)) == "MT 0  ST 2048  90.000000 deg\n" * 20


@pytest.mark.parametrize("delay_ns", [0, 250, 300, 5000])
@pytest.mark.parametrize("clock_hz", [100000, 1000000, 10000000])
def test_a_cable_is_made_up_for(delay_ns, clock_hz):
    wire = ("--set", f"line_delay_ns={delay_ns}", "--set", f"clock_hz={clock_hz}")
    assert ssi(S25, "read", "--shaft", "90DEG", *wire) == "MT 0  ST 2048  90.000000 deg\n"


@pytest.mark.parametrize("how", [("ssi", S25, "read"), ("run", S25, "--sim")])
def test_a_cable_that_is_too_long_for_a_master_that_does_not_compensate(how):
    """300 ns there and 300 ns back are half a period of 833333.3 Hz."""
    long = ("--set", "compensate=0", "--set", "line_delay_ns=300")
    said = run_refused(2, *how, *long)
    assert "compensate=0: " in said and "expected clock_hz up to 833333" in said
    assert "expected clock_hz up to 833333" in run_refused(2, *how, *long, "--set", "clock_hz=833334")
    right = ssi(S25, "read", "--shaft", "90DEG", *long, "--set", "clock_hz=833333")
    assert right == "MT 0  ST 2048  90.000000 deg\n"


# --- the control plane ---


@pytest.fixture
def client(tmp_path):
    address = f"unix:{tmp_path}/ssi.sock"
    encoder = Encoder([S28, "--shaft", "90DEG", "--control", address, "--quiet",
                       "--files", tmp_path])
    time.sleep(0.2)  # it starts for 0.1 s
    with Client(address) as made:
        yield made
    assert encoder.end() == 0


def test_scpi(client):
    state = dict(part.split("=") for part in client.ask("STAT?").split(","))
    assert (state["mode"], state["position"], state["errors"]) == ("idle", "16384", "-")
    assert int(state["frames"]) >= 0 and state["wire_up"] == "1"
    assert client.ask("SSI:FRAM?") == "16384,0,1"
    client.do("SHAF:POS 450DEG")
    assert client.ask("SSI:FRAM?") == f"{65536 + 16384},0,1"
    client.do("WORL:TEMP 101")
    assert client.ask("SSI:FRAM?").split(",")[1] == "1"
    assert "errors=04" in client.ask("STAT?")
    client.do("WORL:DEF")
    client.refused("BISS:FRAM?", -241)
    client.refused("NVM:ERAS", -241)
    assert client.ask("NVM:CAT?") == '""'
    client.do("POW OFF")
    client.refused("SSI:FRAM?", -240)
    client.refused("POW ON;:SSI:FRAM?", -240)  # starting; in one line, as that takes 0.1 s only
    time.sleep(0.2)
    assert client.ask("SSI:FRAM?") == f"{65536 + 16384},0,1"


def test_faults_are_seen_on_the_wire(client):
    names = re.findall(r'"([a-z_]+)",(WORLD|WIRE)', client.ask("FAUL:CAT?"))
    assert len(names) == 19
    for name, kind in names:
        client.do(f"FAUL:SET {name}")
        if kind == "WORLD":
            assert client.ask("SSI:FRAM?") == "16384,1,1", name
        elif name == "wire_damage":
            assert client.ask("SSI:FRAM?").endswith(",0"), name
        else:
            client.refused("SSI:FRAM?", -240)
        client.do(f"FAUL:CLE {name}")
        assert client.ask("SSI:FRAM?") == "16384,0,1", name


def test_a_trace_by_scpi(client, tmp_path):
    trace = tmp_path / "scpi.vcd"
    client.do('TRAC:STAR "scpi.vcd"')
    client.ask("TRAC:LAST? 1")  # what comes from now on
    assert client.ask("SSI:FRAM?") == "16384,0,1"
    client.do("TRAC:STOP")
    found = [position(S28, word) for word in words(trace.read_text())]
    assert found and set(found) == {(16384, 0)}
    assert "position 0:16384" in client.ask("TRAC:LAST? 1")


def test_a_rig_of_several(tmp_path):
    """On one shaft with a BiSS encoder, each on a wire of its own: they agree."""
    text = f"""
[rig]
control = unix:{tmp_path}/rig.sock
[shaft main]
motion = 90DEG
[encoder a]
model = {S25}
shaft = main
wire = sim
[encoder b]
model = {S13}
shaft = main
wire = sim
code = binary
[encoder c]
model = s3684-biss
shaft = main
wire = sim
"""
    file = tmp_path / "rig.ini"
    file.write_text(text, encoding="ascii")
    rig = start_rig(file, "--quiet")
    time.sleep(0.2)
    with Client(f"unix:{tmp_path}/rig.sock") as client:
        client.do("SHAF:POS 810DEG")
        answers = {}
        for name, query in ("a", "SSI:FRAM?"), ("b", "SSI:FRAM?"), ("c", "BISS:FRAM?"):
            client.do(f"INST:SEL {name}")
            answers[name] = int(client.ask(query).split(",")[0])
    assert answers == {"a": 2 << 13 | 2048, "b": 2048, "c": 2 << 21 | 1 << 19}
    assert rig.end() == 0


def test_one_encoder_on_a_line(tmp_path):
    file = tmp_path / "rig.ini"
    encoders = "".join(f"[encoder {name}]\nmodel = {S13}\nbus = line\n" for name in "ab")
    file.write_text(f"[bus line]\nwire = sim\n{encoders}", encoding="ascii")
    assert "expected at most 1 encoders" in run_refused(2, "run", file)


def test_verbose_says_what_was_read():
    encoder = Encoder([S25, "--shaft", "180DEG", "--verbose"])
    assert re.search(r"> position 0:4096$", encoder.errors.wait())
    assert encoder.end() == 0
