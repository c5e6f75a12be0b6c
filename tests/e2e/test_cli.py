# SPDX-License-Identifier: MIT
"""The command line: what it prints, what it refuses, and how."""
import fcntl
import json
import os
import pty
import re
import struct
import subprocess
import termios
import time

import pytest

from rig import MULTITURN, PROGRAM, SINGLETURN, STEPS_PER_TURN, Client, run, run_refused

# Arguments, and what the one line has to name: what would be right.
USAGE_ERRORS = [
    (["--quiet"], r"no command; valid: list faults run .* help; 'drehgeber --help' says more$"),
    (["turntable"], r"unknown command turntable; valid: list faults run .* help; 'drehgeber --help' says more$"),
    (["hlep"], r"unknown command hlep; closest is 'drehgeber help \[COMMAND \[MODEL\]\]'$"),
    (["rum", "f3668"], r"unknown command rum; closest is 'drehgeber run MODEL \[WIRE\] \[OPTIONS\]'$"),
    (["start", "f3668"], r"unknown command start; expected 'drehgeber run f3668'$"),
    (["start", "bench.ini"], r"unknown command start; expected 'drehgeber run bench.ini'$"),
    (["--list"], r"unknown option --list; expected 'drehgeber list \[--json\]'$"),
    (["run", "f3668", "--noed", "5"], r"unknown option --noed; closest is --node N\[\.\.M\]$"),
    (["run", "f3668", "--pyt=x"], r"unknown option --pyt=x; closest is --pty\[=LINK\]$"),
    (["run", MULTITURN, "-p"], r"unknown option -p; closest is --pty\[=LINK\]$"),
    (["run", "f3668", "--bitrate", "250"], r"unknown option --bitrate; valid: --pty --tty .* --version$"),
    (["run", "s3684-biss", "-sim"], r"unknown option -sim; closest is --sim$"),
    (["run", "--quiet", "f3668", "-node", "5"], r"unknown option -node; closest is --node N\[\.\.M\]$"),
    (["run", MULTITURN, "-q", "-pty"], r"unknown option -pty; closest is --pty\[=LINK\]$"),
    (["run", "f3668", "-p", "-sim"], r"unknown option -p; closest is --pty\[=LINK\]$"),
    (["run", "f3668", "-qx"], r"unknown option -qx; valid: --pty --tty .* --version$"),
    (["-hV"], r"unknown option -hV; valid: --pty --tty .* --version$"),
    (["fmu", "f3668", "-o"], r"--output without a value; expected --output FILE$"),
    (["top", "--bitrate", "250"], r"unknown option --bitrate; valid: --control --help$"),
    (["list", "everything"], r"list"),
    (["list", "--json", "--pty"], r"list takes no option --pty; expected 'drehgeber list \[--json\]'$"),
    (["list", "--pty", "--json"], r"list takes no option --pty"),
    (["faults"], rf"faults needs a model; valid: .*{MULTITURN} .*ssi-13 .*ocd-ib-k3$"),
    (["faults", "s3685-rs485"], rf"faults needs a model; valid: .*{MULTITURN}"),
    (["faults", MULTITURN, "now"], r"expected 'drehgeber faults MODEL \[--json\]'$"),
    (["run", MULTITURN, "--json"], r"run takes no option --json; expected 'drehgeber run MODEL"),
    (["run"], r"MODEL|list|" + MULTITURN),
    (["run", "s3685-rs485"], r"list|" + MULTITURN),
    (["run", MULTITURN, "--can", "vcan0"], r"--pty"),
    (["run", MULTITURN, "--tty"], r"--tty"),
    (["run", MULTITURN, "--pty", "--tty", "/dev/null"], r"--pty|--tty"),
    (["run", MULTITURN, "--pty", "--frobnicate"], r"--help|--"),
    (["run", MULTITURN, "--pty", "--nvm"], r"--nvm"),
    (["run", MULTITURN, "--pty", "--shaft"], r"--shaft"),
    (["run", MULTITURN, "--pty", "--shaft", "fast"], r"DEG|RPM|REV"),
    (["run", MULTITURN, "--pty", "--shaft", "90"], r"DEG|RPM|REV"),
    (["run", MULTITURN, "--pty", "--shaft", "90DEGREES"], r"DEG|RPM|REV"),
    (["run", MULTITURN, "--pty", "--shaft", "sine:90DEG"], r"sine:|DEG"),
    (["run", MULTITURN, "--pty", "--shaft", "ramp:3000RPM,0S"], r"ramp:|RPM"),
    (["run", MULTITURN, "--pty", "--shaft", "1e999RPM"], r"RPM"),
    (["run", MULTITURN, "--pty", "--set", "pace"], r"KEY=VALUE|pace="),
    (["run", MULTITURN, "--pty", "--set", "colour=red"], r"pace|init_ms|line"),
    (["run", MULTITURN, "--pty", "--set", "init_ms=soon"], r"\d"),
    (["run", MULTITURN, "--pty", "--set", "init_ms=-1"], r"\d"),
    (["run", MULTITURN, "--pty", "--set", "line=maybe"], r"any"),
    (["run", MULTITURN, "--pty", "--serial", "1234567890"], r"9"),
    (["run", MULTITURN, "--pty", "--control"], r"--control ADDRESS"),
    (["run", MULTITURN, "--pty", "--control", "5025"], r"unix:PATH|tcp:HOST:PORT"),
    (["run", MULTITURN, "--pty", *["--control", "tcp:127.0.0.1:0"] * 5], r"4"),
    (["run", MULTITURN, "--node", "5"], r"--node 5"),
    (["run", "f3668", "--slcan", "--node", "5..4"], r"1\.\.127"),
    (["run", "f3668", "--slcan", "--node", "1..128"], r"1\.\.127"),
    (["run", MULTITURN, "--pty", "/tmp/x"], r"/tmp/x; expected --pty=/tmp/x$"),
    (["run", "f3668", "--slcan", "/tmp/x"], r"/tmp/x; expected --slcan=/tmp/x$"),
    (["run", MULTITURN, "f3668"], r"'drehgeber run RIG\.ini'"),
    (["eds", "f3658", "out.eds"], r"expected 'drehgeber eds f3658 > out\.eds'$"),
    ([MULTITURN], rf"expected 'drehgeber run {MULTITURN}'$"),
    (["map", "ocd-ib-k3", "out"], r"expected 'drehgeber map MODEL'$"),
    (["run", MULTITURN, "--shaft", "90"], r"--shaft 90: '90' has no unit; expected 90DEG or 90RPM, for example$"),
    (["run", MULTITURN, "--shaft", "sine:90"], r"an angle such as 90DEG"),
    (["run", MULTITURN, "--nvm", ""], r"--nvm: empty; expected --nvm FILE$"),
    (["run", "ocd-ib-k3", "--ring", ""], r"--ring: empty; expected --ring MODELS$"),
    (["run", "ocd-ib-k3", "--ring", "ocd-ib-k1,x"], r"--ring x: 'x' is no INTERBUS model; valid: ocd-ib-k1 ocd-ib-k2 ocd-ib-k3, "),
    (["run", MULTITURN, "--ring", "x"], rf"--ring x: '{MULTITURN}' is no INTERBUS model; valid: ocd-ib-k1 "),
    (["run", MULTITURN, "--set", "date=x"], r"--set date=x: expected 8 characters$"),
    (["run", MULTITURN, "--set", "=1"], r"--set =1: expected KEY=VALUE$"),
    (["run", "s3684-biss", "--gpio", "x:1,2", "--set", "clock_hz=1000000"], r"only a sim wire has it; leave it out$"),
    (["run", "s3684-biss", "--sim", "--set", "pace=0"], r"--set pace=0: only pty, tty, .* or silkit wires have it; leave it out$"),
    (["biss", "s3684-biss", "registers"], r"no address; expected read, "),
    (["biss", "s3684-biss", "registers", "78"], r"registers 0x4E \(78\) needs a number N of 1\.\.50; expected read, "),
]

# What is asked about, and words that its help has to have; nothing is started.
HELP = [
    (["--help"], ["drehgeber run MODEL", "--pty", "KEY=VALUE of BiSS encoders", "mt_bits",
                  "(own or any, default own)", "(0..1000000 us, default 1000)"]),
    (["help"], ["drehgeber run MODEL"]),
    (["help", "run", MULTITURN], ["date of the firmware (factory) (8 characters)"]),
    (["help", "run", "ocd-ib-k3"], ["0 is the first\n", "(fault) (0..511)"]),
    (["help", "run"], ["drehgeber run MODEL", "drehgeber run RIG.ini", "--modbus=HOST:PORT", "MOTION"]),
    (["run", "--help"], ["drehgeber run MODEL", "drehgeber run RIG.ini", "--pty[=LINK]"]),
    (["run", MULTITURN, "--help"], ["--pty[=LINK]", "pty is its usual wire", "reaction_us", "default 1000)", "turns", "4096)"]),
    (["run", SINGLETURN, "-h"], ["turns", "default 1)"]),
    (["run", "s3684-biss", "--nvm", "x", "--help"], ["stop_bit", "clock_hz", "default 1000000)"]),
    (["run", "f3668", "--help"], ["mt_bits", "pace"]),
    (["run", "rig.ini", "--help"], ["drehgeber run RIG.ini"]),
    (["biss", "--help"], ["drehgeber biss MODEL ACTION", "registers [BANK:]ADDR N"]),
    (["biss", "s3684-biss", "read", "--help"], ["drehgeber biss MODEL ACTION", "busy_us"]),
    (["eds", "--help"], ["drehgeber eds MODEL"]),
    (["eds", "f3668", "--help"], ["drehgeber eds MODEL"]),
    (["map", "--help"], ["drehgeber map MODEL", "--ring"]),
    (["ctl", "--help"], ["drehgeber ctl", "--control"]),
    (["top", "--help"], ["drehgeber top"]),
    (["list", "--help"], ["drehgeber list", "--json"]),
    (["faults", "--help"], ["drehgeber faults MODEL", "--json"]),
]

BAD_CSV = [
    ("0,0\n1,90\n2,banana\n", 3),
    ("0,0\n1,90\n0.5,180\n", 3),
    ("0,0\n1\n", 2),
]


def test_help_has_what_the_command_takes():
    """No settings of wires that it has not, no courses where nothing goes on, no heading without rows."""
    def keys(*arguments):
        return run(*arguments, "--help").stdout.partition("KEY=VALUE of")[2]

    of_fmu, of_biss, of_run = keys("fmu", "f3668"), keys("biss", "s3684-biss"), keys("run", "f3668")
    for word in ("pace", "step_us", "time_s", "factory"):
        assert word not in of_fmu and (word in of_run) == (word != "factory")
    for command in (of_biss, keys("ssi", "ssi-25")):
        assert "clock_hz" in command and "step_us" not in command and "time_s" not in command
    assert "of f3658" not in keys("run", "f3658")
    assert keys("run", "f3658").startswith(" --can, --slcan")
    assert "KEY=VALUE of what it senses" in run("fmu", "f3658", "--help").stdout
    for model in (MULTITURN, "ocd-ib-k3"):
        assert "(factory): a new" in keys("run", model) and "(factory): a new" not in keys("fmu", model)


@pytest.mark.parametrize("wire", ["rs485", "slcan", "socketcand", "modbus"])
def test_help_says_how_others_get_in(wire):
    row = re.search(rf"^ +--{wire}\b.*?(?=\n\s+--)", run("run", "--help").stdout, re.S | re.M)[0]
    assert "add ,open to accept other machines than this one" in " ".join(row.split())


def test_alone_it_prints_the_help():
    """For whoever wants to know; a script that has lost its command is told by the status."""
    ended = run()
    assert (ended.returncode, ended.stderr) == (2, "")
    assert ended.stdout == run("--help").stdout


COMMANDS = ["list", "faults", "run", "eds", "model", "biss", "ssi", "map", "fmu", "ctl", "top", "verify", "web", "help"]


def test_every_help_is_80_columns_wide():
    asked = [["--help"], *([command, "--help"] for command in COMMANDS),
             *(["help", command, model] for command in ("run", "biss", "ssi", "fmu", "faults") for model in models())]
    for arguments in asked:
        ended = run(*arguments)
        assert ended.returncode == 0
        lines = ended.stdout.splitlines()
        assert len(lines) > 3 and max(map(len, lines)) <= 80, (arguments, [line for line in lines if len(line) > 80])
        assert all(re.match(r" {2,6}-|  -\w, --", line) for line in lines if line.lstrip().startswith("--")), arguments


def options_of(*arguments):
    return set(re.findall(r"^ {2,6}(?:-\w, )?--(\w+)", run(*arguments).stdout, re.M))


@pytest.mark.parametrize("model", [entry["model"] for entry in json.loads(run("list", "--json").stdout)])
def test_help_of_a_model_has_its_wires_only(model):
    """... and none of the options that are another protocol's."""
    entries = json.loads(run("list", "--json").stdout)
    mine = next(entry for entry in entries if entry["model"] == model)
    kinds = {wire for entry in entries for wire in entry["wires"]}
    told = options_of("run", model, "--help")
    assert told & kinds == set(mine["wires"])
    assert ("ring" in told) == ("modbus" in mine["wires"]) and ("node" in told) == ("can" in mine["wires"])
    assert told | kinds | {"ring", "node"} == options_of("run", "--help")


def test_settings_stand_below_what_they_belong_to():
    said = run("run", "ocd-ib-k3", "--help").stdout
    headed = re.findall(r"^ of (.*):$", said, re.M)
    assert headed == ["--silkit", "--modbus"]
    assert re.search(r"^ of --silkit:\n  time +time of the SIL Kit simulation", said, re.M)
    assert re.search(r"^ of --can, --slcan.*:\n  pace ", run("run", "f3668", "--help").stdout, re.M)


def test_list():
    ended = run("list")
    assert (ended.returncode, ended.stderr) == (0, "")
    lines = ended.stdout.splitlines()
    assert {MULTITURN, SINGLETURN} <= {line.split()[0] for line in lines}
    for line in lines:
        if line.split()[0] in (MULTITURN, SINGLETURN):
            assert "RS485" in line and "2048" in line


def models():
    return [line.split()[0] for line in run("list").stdout.splitlines()]


def test_list_for_programs():
    said = json.loads(run("list", "--json").stdout)
    assert [model["model"] for model in said] == models()
    for model, line in zip(said, run("list").stdout.splitlines()):
        assert line.split(maxsplit=1)[1] == f"{model['speaks']}, {model['resolution']}"
        assert model["usual_wire"] in model["wires"]
    wires = {model["model"]: model["wires"] for model in said}
    assert (wires[MULTITURN][:3], wires["f3668"][:3]) == (["pty", "tty", "rs485"], ["can", "slcan", "socketcand"])
    assert (wires["ssi-13"][:2], wires["ocd-ib-k1"][:2]) == (["sim", "gpio"], ["silkit", "modbus"])


@pytest.mark.parametrize("model", models())
def test_faults(model):
    """The table has what the catalogue for programs has, in lines that fit a terminal."""
    ended = run("faults", model)
    assert (ended.returncode, ended.stderr) == (0, "")
    lines = ended.stdout.splitlines()
    assert model in lines[0] and max(len(line) for line in lines) <= 80
    told = " ".join(ended.stdout.split())
    faults = json.loads(run("faults", model, "--json").stdout)
    assert len(faults) >= 5 and len({fault["name"] for fault in faults}) == len(faults)
    for fault in faults:
        assert fault["kind"] in ("WORLD", "MEMORY", "WIRE")
        assert f"{fault['name']} {fault['cause']} -> {fault['effect']} ({fault['chapter']})" in told


def test_faults_are_those_of_the_encoder(start):
    encoder = start("--control", "tcp:127.0.0.1:0")
    with Client(int(encoder.out.wait().rsplit(":", 1)[1])) as client:
        catalogue = client.ask("FAUL:CAT?")
    for fault in json.loads(run("faults", MULTITURN, "--json").stdout):
        assert f'"{fault["name"]}",{fault["kind"]},"{fault["cause"]}","{fault["effect"]}"' in catalogue


def test_faults_of_a_wide_terminal():
    master, slave = pty.openpty()
    fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 110, 0, 0))
    with subprocess.Popen([PROGRAM, "faults", "ssi-13"], stdout=slave) as process:
        os.close(slave)
        said = b""
        try:
            while part := os.read(master, 4096):
                said += part
        except OSError:  # the other end is closed
            pass
        assert process.wait(10) == 0
    os.close(master)
    assert 80 < max(len(line) for line in said.decode().splitlines()) <= 110


def test_help():
    ended = run("--help")
    assert (ended.returncode, ended.stderr) == (0, "")
    for word in ["list", "run", "--pty", "--tty", "--nvm", "--serial", "--shaft", "--set"]:
        assert word in ended.stdout


@pytest.mark.parametrize("arguments, words", HELP, ids=lambda value: " ".join(value))
def test_help_of_a_command(arguments, words):
    ended = run(*arguments)
    assert (ended.returncode, ended.stderr) == (0, "")
    for word in words:
        assert word in ended.stdout, word
    assert "ready" not in ended.stdout.splitlines()[0]


def test_help_is_about_what_was_asked():
    """Of another command, of another kind of encoder there is not a word."""
    said = run("run", MULTITURN, "--help").stdout
    assert "stop_bit" not in said and "mt_bits" not in said and "clock_hz" not in said
    assert "--pty" not in run("ctl", "--help").stdout
    assert "KEY=VALUE of" not in run("run", "--help").stdout


@pytest.mark.parametrize("arguments", [["--version"], ["run", MULTITURN, "--version"], ["-V"]],
                         ids=lambda value: " ".join(value))
def test_version(arguments):
    ended = run(*arguments)
    assert (ended.returncode, ended.stderr) == (0, "")
    assert re.fullmatch(r"drehgeber \d+\.\d+\.\d+\S*\n", ended.stdout)


@pytest.mark.parametrize("arguments, right", USAGE_ERRORS, ids=lambda value: " ".join(value)
                         if isinstance(value, list) else "")
def test_usage_errors(arguments, right):
    line = run_refused(2, *arguments)
    assert re.search(right, line), line


def test_missing_device():
    line = run_refused(1, "run", MULTITURN, "--tty", "/dev/does-not-exist")
    assert "/dev/does-not-exist" in line


def test_ready_line(start, tmp_path):
    link = tmp_path / "encoder"
    for wire in [["--pty"], [f"--pty={link}"]]:
        encoder = start(wire=wire)
        found = re.fullmatch(rf"ready {MULTITURN} pty:(/\S+)", encoder.ready_line)
        assert found, encoder.ready_line
        assert re.fullmatch(r"/dev/pts/\d+", os.path.realpath(found[1]))
        assert encoder.out.so_far() == []
    assert os.path.realpath(link) == os.path.realpath(found[1])


def test_control_line(start):
    encoder = start("--control", "tcp:127.0.0.1:0")
    assert re.fullmatch(r"control tcp:127\.0\.0\.1:\d+", encoder.out.wait())


def turned(master, seconds: float) -> tuple[int, float, float]:
    """Counts turned over some time, and the bounds of that time."""
    def sample():
        before = time.monotonic()
        position = master.read_position()
        return before, position, time.monotonic()
    first = sample()
    time.sleep(seconds)
    last = sample()
    return last[1] - first[1], last[0] - first[2], last[2] - first[0]


@pytest.mark.parametrize("speed, counts_per_s", [("60RPM", 65536), ("-60RPM", -65536)])
def test_constant_speed(start, speed, counts_per_s):
    master = start("--shaft", speed, "--set", "pace=0").master()
    master.set_position(1 << 27)
    counts, shortest, longest = turned(master, 1.5)
    assert 0.99 * shortest * abs(counts_per_s) <= abs(counts) <= 1.01 * longest * abs(counts_per_s)
    assert (counts > 0) == (counts_per_s > 0)


def test_ramp(start):
    encoder = start("--shaft", "ramp:3000RPM,1S")
    master = encoder.master()
    time.sleep(max(0.0, encoder.ready + 1.05 - time.monotonic()))
    before = time.monotonic()
    turns = master.read_position() / STEPS_PER_TURN
    after = time.monotonic()
    # 25 turns in the first second, then 50 a second; it began between start and ready.
    assert 50 * (before - encoder.ready) - 26 <= turns <= 50 * (after - encoder.started) - 24
    counts, shortest, longest = turned(master, 0.5)
    assert 0.99 * shortest * 50 <= counts / STEPS_PER_TURN <= 1.01 * longest * 50


def test_sine(start):
    master = start("--shaft", "sine:90DEG,1S").master()
    master.set_position(1 << 27)
    positions = []
    end = time.monotonic() + 2.2
    while time.monotonic() < end:
        positions.append(master.read_position())
    # The preset was somewhere on the sine: only the span is known, twice 90 degrees.
    assert 0.95 * STEPS_PER_TURN / 2 <= max(positions) - min(positions) <= STEPS_PER_TURN / 2 + 1


def test_csv(start, tmp_path):
    motion = tmp_path / "motion.csv"
    motion.write_text("0,90\n0.001,180\n")
    encoder = start("--shaft", motion)
    assert encoder.master().read_position() == STEPS_PER_TURN // 2  # at rest behind its end


@pytest.mark.parametrize("text, number", BAD_CSV)
def test_csv_error_names_the_line(tmp_path, text, number):
    motion = tmp_path / "motion.csv"
    motion.write_text(text)
    ended = run("run", MULTITURN, "--pty", "--shaft", motion)
    assert ended.returncode in (1, 2) and ended.stdout == ""
    assert len(ended.stderr.splitlines()) == 1
    assert re.search(rf"motion\.csv\D+{number}\b", ended.stderr), ended.stderr


def test_csv_with_byte_order_mark(start, tmp_path):
    motion = tmp_path / "motion.csv"
    motion.write_bytes(b"\xef\xbb\xbf0,90\r\n1,90\r\n")
    assert start("--shaft", motion).master().read_position() == 65536 // 4


def test_csv_missing(tmp_path):
    ended = run("run", MULTITURN, "--pty", "--shaft", tmp_path / "none.csv")
    assert ended.returncode in (1, 2) and ended.stdout == ""
    assert len(ended.stderr.splitlines()) == 1 and "none.csv" in ended.stderr
