# SPDX-License-Identifier: MIT
"""What the command says to a command line, whole: status, stdout, stderr and files.

tests/golden/said.record has it, which somebody has read; `DREHGEBER_UPDATE=1 pytest test_cli_said.py` writes it anew,
and the difference is to be read. What differs from run to run stands there as {...}."""
import os
import re
import shlex

import pytest

from rig import REPOSITORY, run

RECORD = REPOSITORY / "tests/golden/said.record"

RIG = """[rig]
name = two
[shaft main]
motion = 60RPM
[shaft slow]
driver = main
ratio = 1:10
[encoder first-one]
model = s3684-biss
wire = sim
clock_hz = 500000
[encoder 2nd]
model = f3668
wire = slcan
shaft = slow
node = 9
nvm = second.nvm
[encoder third]
model = ssi-25
shaft = slow
wire = sim
"""

COMMANDS = """
--help
run --help
run s3684-rs485 --help
run f3668 --help
run ocd-ib-k3 --help
biss s3684-biss --help
ssi ssi-25 -h
fmu f3658 --help
map --help
eds --help
ctl --help
top --help
web --help
explain --help
list --help
faults --help
help help
list
list --json
faults ssi-13
faults s3674-rs485
faults f3668
faults ssi-13 --json
map ocd-ib-k2
map --ring ocd-ib-k3,ocd-ib-k1
map
map f3668
map ocd-ib-k3 --ring ocd-ib-k9
map --ring ocd-ib-k1,f3668
map --ring
eds
eds s3684-biss
eds f3658 --node 5
biss s3684-biss eds
biss s3674-biss eds
biss s3684-biss read read --shaft -90DEG
biss s3684-biss registers 0x78 8
biss s3684-biss registers 0x50 33
biss s3684-biss registers 0x7F 1
biss s3684-biss registers 0x7F 2
biss s3684-biss registers 0x7F 0
biss s3684-biss registers 7:0 64 write 7:63 a5 registers 7:60 4
biss s3684-biss registers 8:0 1 write 8:0 0102 03 0a0B registers 8:0 8 read
biss s3684-biss write 0x20
biss s3684-biss write 0x20 1
biss s3684-biss write 0x20 1x
biss s3684-biss write 0x48 FF
biss s3684-biss registers 31:0 1 registers 32:0 1
biss s3684-biss registers 255:0 1
biss s3684-biss registers 1234567:0 1
biss s3684-biss registers 12345678:0 1
biss s3684-biss command 255
biss s3684-biss command 0x100
biss s3684-biss command x
biss s3684-biss command 3 read
biss s3684-biss command 3 read read registers 0x78 1
biss s3684-biss read --set data_stuck=1
biss s3684-biss read --set temperature=x.csv
biss s3684-biss read --shaft nowhere.csv
biss s3684-biss read --shaft nonsense
biss s3684-biss read --trace x.log
biss s3684-biss read --trace nowhere/x.vcd
biss s3684-biss read --pty
biss s3684-biss read --gpio x:1,2
biss s3684-biss
biss f3668 read
biss
ssi ssi-25 read read --shaft 90DEG
ssi ssi-25 read write
ssi ssi-25 read --gpio x:1,2
ssi ssi-13
ssi s3684-biss read
run s3684-biss --sim --shaft 60RPM --time virtual:2S
run s3684-biss --shaft 60RPM --time virtual:2S --quiet
run s3684-biss --shaft 60RPM --time virtual:1001MS --verbose
run f3668 --slcan --node 3..5 --serial 7 --nvm x --time virtual:1S
run f3668 --slcan --node 127 --nvm x --time virtual:1S
run f3668 --slcan --node 128
run f3668 --slcan --node 0
run f3668 --slcan --node 1..
run f3668 --slcan --node 1...2
run f3668 --slcan --node 0001
run f3668 --slcan --node 3..3 --nvm x --time virtual:1S
run f3668 --slcan --node 1,2
run f3668 --slcan --serial 4294967296
run f3668 --slcan --serial x --node 1..2
run ocd-ib-k3 --modbus 127.0.0.1:0 --ring ocd-ib-k3,ocd-ib-k1 --nvm x --time virtual:1S
run --modbus 127.0.0.1:0 --ring ocd-ib-k2 --time virtual:1S
run ocd-ib-k3 --modbus 127.0.0.1:0 --ring ocd-ib-k3,
run f3668 --modbus 127.0.0.1:0 --ring ocd-ib-k3
run ocd-ib-k3 --serial 999999999 --modbus 127.0.0.1:0 --time virtual:1S
run s3684-rs485 --serial 123456789 --nvm x --time virtual:10MS --pty
run s3684-rs485 --pty --trace x.csv
run s3684-rs485 --pty --trace nowhere/x.vcd
run s3684-rs485 --pty --set pace=x
run s3684-rs485 --can
run s3684-rs485 --pty= --time virtual:1S
run s3684-rs485 --pty --pty
run s3684-rs485 --pty --slcan
run s3684-rs485 --pty --control nowhere
run s3684-rs485 --pty --control tcp:0.0.0.0:0
run s3684-rs485 --pty --control unix:nowhere/x.sock
run s3684-rs485 --time virtual:1S --control unix:a.sock --control unix:b.sock --pty
run two.ini --time virtual:1S
run ./two.ini --time virtual:1S --control tcp:127.0.0.1:0
run two.ini --set pace=1
run two.ini --nvm x
run two.ini --serial 1
run two.ini --node 1
run two.ini --shaft 1RPM
run two.ini --trace x.vcd
run two.ini --ring ocd-ib-k1
run two.ini --pty
run none.ini
run ./none
run two.INI
run two.inix
run --time virtual:1S
run s3684-rs485 --pty --time virtual:8760H1
run s3684-rs485 --time 1S
run s3684-rs485 --tty /dev/null --time virtual:1S
run s3684-biss --gpio x:1,2 --time virtual:1S
run s3684-rs485 s3684-biss
run s3684-rs485 --nvm
run s3684-rs485 --nvm=
run s3684-rs485 --shaft=
run s3684-rs485 --control=
run s3684-rs485 --set=
run s3684-rs485 --trace=
run s3684-rs485 --files= --pty
run s3684-rs485 --files /nowhere --pty --time virtual:1S
run s3684-rs485 --quiet=1
run s3684-rs485 -x
run s3684-rs485 -q -p
run --time virtual:1S --pty -- s3684-rs485
run s3684-rs485 --nmv x
run s3684-rs485 --n x
run s3684-rs485 --output x.fmu
run s3684-rs485 --fmi 2
run s3684-rs485 --listen 127.0.0.1:0
run s3684-rs485 --token x
run s3684-rs485 --watch
run s3684-rs485 --timeout 1S
lits
runn
f3668
./x.ini
ctl --json x
ctl --timeout 1H1
ctl x
ctl --control nowhere x
ctl --control unix:nowhere.sock x
ctl --control tcp:127.0.0.1:1 x
top
top unix:nowhere.sock
top --json
top --node 3
web --listen
web unix:a unix:b
web --node 3
fmu f3668
fmu f3668 --output x
fmu f3668 --output x.FMU
fmu f3668 -o x.fmu --fmi 4
fmu f3668 -o x.fmu --fmi 22
fmu f3668 -o x.fmu --set mt_bits=99
fmu f3668 -o x.fmu --set pace=1
fmu f3668 -o x.fmu --set nothing=1
fmu f3668 -o x.fmu --node 1..3 --serial 5
fmu two.ini -o x.fmu
fmu two.ini -o x.fmu --fmi 2
fmu two.ini -o two.ini
fmu two.ini -o two
fmu two.ini -o nowhere/x.fmu
fmu two.ini -o x.fmu --node 1
verify
verify s3684-rs485
verify s3684-biss --gpio x:1,2
verify s3684-rs485 --can can0
verify s3684-rs485 --tty nowhere
verify s3684-rs485 --tty /dev/null 9.9
verify s3684-rs485 --tty /dev/null 5.1.2.1 M12
verify s3684-rs485 --tty /dev/null --journal x
verify s3684-rs485 --tty /dev/null --irreversible
verify s3684-rs485 --tty /dev/null --restore --journal x
verify s3684-rs485 --tty /dev/null --address 0x90
verify f3668 --slcan=nowhere --node 0
verify f3668 --slcan=nowhere M12-7
verify f3668 --pty x
verify ocd-ib-k3 --modbus nowhere
verify ocd-ib-k3 --modbus 127.0.0.1:1
verify ocd-ib-k3 --can can0
verify f36
explain
explain none.log
explain two.ini
explain two.ini --against f3
explain two.ini --against f3668 --node 5
explain two.ini two.ini
model
model f3668
model f36 --c
model two.ini --c
model --c
check
check two.ini
check none.ini
check two.ini two.ini
check f3668
eds none.eds
eds two.ini
eds f3668 --explain
eds f3668 --node 200
biss s3684-biss read --model two.ini
biss --model two.ini read
run --model none.ini --pty
run s3684-rs485 --nvm-convert x
run f3668 --slcan --nvm-convert none.nvm
run f3668 --slcan --nvm x --nvm-convert none.nvm
run ssi-25 --sim --nvm x
run f3668 --sim
web --listen 127.0.0.1
--version
-V
--
-
""".strip().split("\n")


def told(line, folder):
    """All that a command line does."""
    (folder / "two.ini").write_text(RIG)
    clean = {key: value for key, value in os.environ.items() if key not in ("RUNTIME_DIRECTORY", "DREHGEBER")}
    ended = run(*shlex.split(line), cwd=folder, env={**clean, "XDG_RUNTIME_DIR": str(folder)})
    said = ended.stdout + "".join(f"! {row}\n" for row in ended.stderr.splitlines())
    said = said.replace(str(folder), "{folder}")
    said = re.sub(r"/dev/pts/\d+", "{pty}", said)
    said = re.sub(r'[^"]*/share/drehgeber/models/', "{models}/", said)
    said = re.sub(r"(?<=127\.0\.0\.1:)[1-9]\d{3,}", "{port}", said)
    said = re.sub(r"^drehgeber \d+\.\d+\.\d+\S*$", "drehgeber {version}", said, flags=re.M)
    files = sorted(path.name for path in folder.iterdir() if path.name not in ("two.ini", "drehgeber"))
    made = f"? files: {' '.join(files)}\n" if files else ""
    return f"$ {line}\n{said}{made}? status: {ended.returncode}\n"


def recorded():
    return dict(re.findall(r"(?ms)^\$ ([^\n]*)\n(.*?^\? status: \d+\n)", RECORD.read_text()))


if "DREHGEBER_UPDATE" in os.environ:
    def test_update(tmp_path):
        parts = []
        for number, line in enumerate(COMMANDS):
            (tmp_path / str(number)).mkdir()
            parts.append(told(line, tmp_path / str(number)))
        RECORD.write_text("\n".join(parts))


def test_each_record_has_a_command():
    assert list(recorded()) == COMMANDS


@pytest.mark.parametrize("line", COMMANDS)
def test_said(line, tmp_path):
    assert told(line, tmp_path) == f"$ {line}\n{recorded()[line]}"
