# SPDX-License-Identifier: MIT
"""Rigs and the control plane, used as badly as can be: nothing hangs, nobody waits, nothing lies."""
import os
import resource
import time

import pytest
import serial

from hiperface_master import Master
from rig import PATIENCE_S, Client, Encoder, Rigs, run_refused

CONTROLLED = "[rig]\ncontrol = tcp:127.0.0.1:0\n"
SIMULATED = CONTROLLED + "[encoder a]\nmodel = s3684-biss\nwire = sim\n"
ON_A_LINE = CONTROLLED + "[encoder a]\nmodel = s3684-rs485\nwire = pty:line\n"
TWO_ON_CAN = ("[encoder a]\nmodel = f3668\nwire = slcan\n{}[encoder b]\nmodel = f3668\nwire = slcan\n"
              "{}")
# A round of the loop catches up with at most 1000 frames. Of eight encoders with a trace, in a build that counts its
# branches, these take 5 s; without that limit a round takes longer than it catches up with, and none ends.
SOON_S = 10.0


class Impatient(Client):
    def ask_soon(self, bench: Encoder, text: str) -> str:
        """In processor time of the rig: a busy machine gives it little."""
        self.line.settimeout(60)
        before = bench.cpu_ticks()
        answer = self.ask(text)
        assert bench.cpu_ticks() - before < SOON_S * 100, text
        return answer


@pytest.fixture
def rig(tmp_path):
    """Start a rig: rig(TEXT); its clients are closed and it ends when it is told to."""
    rigs = Rigs(tmp_path, Impatient)
    yield rigs.begin
    rigs.end()


# --- files --------------------------------------------------------------------------------------

@pytest.mark.parametrize("command, code", [('SHAF:REC:STAR "{}"', -257), ('SHAF:PROF "{}"', -256)])
def test_a_pipe_holds_up_nobody(rig, tmp_path, command, code):
    pipe = tmp_path / "pipe.csv"
    os.mkfifo(pipe)
    bench = rig(ON_A_LINE)
    assert bench.client().error(command.format(pipe)) == code
    with Master(str(tmp_path / "line")) as master:
        master.read_position()
    assert bench.end() == 0


def test_a_recording_on_a_full_disk(rig, tmp_path):
    bench = rig(SIMULATED)
    client = bench.client()
    assert client.error(f'TIME:SCAL 0;:SHAF:REC:STAR "{tmp_path}/r.csv"') == 0
    bench.limit_file_size(1000)
    assert client.error("TIME:STEP 10S") == 0
    assert client.error("SHAF:REC:STOP") == -250
    assert (tmp_path / "r.csv").stat().st_size == 1000
    bench.limit_file_size(resource.RLIM_INFINITY)


def test_one_file_is_of_one_recording(rig, tmp_path):
    text = CONTROLLED + ("[shaft m]\n[shaft n]\n[encoder a]\nmodel = f3668\nwire = slcan\nshaft = m\n"
                         "[encoder b]\nmodel = f3668\nwire = slcan\nshaft = n\nnvm = b.csv\n")
    client = rig(text).client()
    assert client.error(f'SHAF:REC:STAR "{tmp_path}/r.csv"') == 0
    assert client.error(f'INST:SEL b;:SHAF:REC:STAR "{tmp_path}/./r.csv"') == -257
    image = (tmp_path / "b.csv").read_bytes()
    assert client.error(f'SHAF:REC:STAR "{tmp_path}/b.csv"') == -257
    assert (tmp_path / "b.csv").read_bytes() == image
    assert client.error("INST:SEL a;:SHAF:REC:STOP") == 0


@pytest.mark.parametrize("other", ["./a.nvm", "symbolic", "hard"])
def test_one_eeprom_is_of_one_encoder(rig, tmp_path, other):
    assert rig(TWO_ON_CAN.format("nvm = a.nvm\n", "")).end() == 0
    (tmp_path / "symbolic").symlink_to("a.nvm")
    (tmp_path / "hard").hardlink_to(tmp_path / "a.nvm")
    file = tmp_path / "rig.ini"
    file.write_text(TWO_ON_CAN.format("nvm = a.nvm\n", f"nvm = {other}\n"))
    said = run_refused(1, "run", file)
    assert f"{file}:8: " in said and "in use by another encoder" in said
    assert said.count(str(file)) == 1


def test_the_lock_of_an_eeprom_lasts(rig, tmp_path):
    """Also after this process had the file open a second time, for a recording that it refused."""
    image = tmp_path / "a.csv"
    bench = rig(CONTROLLED + f"[encoder a]\nmodel = f3668\nwire = slcan\nnvm = {image}\n")
    assert bench.client().error(f'SHAF:REC:STAR "{image}"') == -257
    said = run_refused(1, "run", "f3668", "--slcan", "--nvm", image)
    assert f"in use by process {bench.pid};" in said


def test_as_many_files_as_there_are_encoders(rig):
    def few_files():
        resource.setrlimit(resource.RLIMIT_NOFILE, (64, 1024))

    encoders = "".join(f"[encoder e{i}]\nmodel = ocd-ib-k3\nbus = ring\nnvm = {i}.nvm\n"
                       for i in range(100))
    assert rig("[bus ring]\nwire = modbus\naddress = 127.0.0.1:0\n" + encoders,
               preexec_fn=few_files).end() == 0


# --- time ---------------------------------------------------------------------------------------

def test_a_clock_too_fast_for_the_wire_can_be_stopped(rig):
    encoders = "".join(f"[encoder e{i}]\nmodel = s3684-biss\nbus = b\n" for i in range(8))
    bench = rig(CONTROLLED + "[bus b]\nwire = sim\ntrace = t.vcd\n" + encoders)
    client = bench.client()
    assert client.error("TIME:SCAL 1000") == 0
    time.sleep(1)
    assert client.ask_soon(bench, "INST:SEL?") == '"e0"'
    assert client.error("TIME:SCAL 0") == 0
    assert bench.end() == 0


def test_a_clock_too_fast_for_a_recording(rig, tmp_path):
    bench = rig(SIMULATED)
    client = bench.client()
    assert client.error(f'TIME:SCAL 1000;:SHAF:REC:STAR "{tmp_path}/r.csv",100US') == 0
    assert client.ask_soon(bench, "INST:SEL?") == '"a"'
    assert client.error("TIME:SCAL 0;STEP 3600S") == 0
    assert client.error("SHAF:REC:STOP") == -250
    assert "too many lines at once" in bench.errors.wait()
    assert bench.end() == 0


def test_after_a_step_it_is_later_for_the_rest_of_the_line_and_for_others(rig):
    bench = rig(SIMULATED)
    client, other = bench.client(), bench.client()
    assert client.error("TIME:SCAL 0;:SHAF:POS 0;VEL 1RPM") == 0
    assert float(client.ask("TIME:STEP 10S;:SHAF:POS?")) == pytest.approx(60, abs=1e-3)
    assert float(client.ask("TIME:STEP 10S;STEP 5S;:SHAF:STOP;:SHAF:POS?")) == pytest.approx(
        150, abs=1e-3)
    assert float(other.ask("SHAF:POS?")) == pytest.approx(150, abs=1e-3)


@pytest.mark.parametrize("address", [0, 1])
def test_who_waits_is_told_what_others_did(rig, address):
    bench = rig(ON_A_LINE.replace("0\n[", "0\ncontrol = tcp:127.0.0.1:0\n[", 1))
    waiting, steering = bench.client(0), bench.client(address)
    assert waiting.error("SHAF:MOVE 100000,1RPM") == 0
    waiting.send("*OPC?")
    time.sleep(0.2)
    assert steering.error("SHAF:STOP") == 0
    begin = time.monotonic()
    assert waiting.answers.readline() == "1\n"
    assert time.monotonic() - begin < SOON_S


# --- clients ------------------------------------------------------------------------------------

def test_stderr_that_nobody_reads_holds_up_nobody(rig):
    bench = rig(SIMULATED, "--verbose")
    client = bench.client()
    assert client.error("TIME:SCAL 1000") == 0
    time.sleep(1)  # some thousand lines: more than a pipe holds
    assert client.error("TIME:SCAL 0") == 0
    bench.errors.so_far()
    assert client.error("TIME:STEP 1S") == 0
    assert "lines left out" in bench.errors.wait()
    assert bench.end() == 0


def test_many_questions_at_once_are_all_answered(rig):
    encoders = "".join(f"[encoder {'e' * 28}{i:03}]\nmodel = ocd-ib-k3\nbus = ring\n"
                       for i in range(200))
    bench = rig(CONTROLLED + "[bus ring]\nwire = modbus\naddress = 127.0.0.1:0\n" + encoders)
    client, other = bench.client(), bench.client()
    answer = ";".join([client.ask("INST:CAT?")] * 99) + "\n"
    count = 20
    client.line.sendall((b"INST:" + b"CAT?;" * 99 + b"\n") * count)  # 13 megabytes of answers
    for _ in range(count):
        other.ask("INST:SEL?")  # meanwhile nobody reads the answers, and they do not fit into the socket
    assert all(client.answers.readline() == answer for _ in range(count))


def test_answers_that_nobody_reads_hold_up_nobody(rig):
    bench = rig(SIMULATED)
    lazy, client = bench.client(), bench.client()
    lazy.line.setblocking(False)
    with pytest.raises(OSError):
        while True:
            lazy.line.send(b"SYST:HELP?\n" * 1000)
    assert client.ask_soon(bench, "INST:SEL?") == '"a"'
    assert bench.end() == 0


def test_without_descriptors_it_waits_quietly(rig):
    def few_files():
        resource.setrlimit(resource.RLIMIT_NOFILE, (24, 24))

    bench = rig(SIMULATED, preexec_fn=few_files)
    clients = [bench.client() for _ in range(25)]
    before = bench.cpu_ticks()
    time.sleep(1)
    assert bench.cpu_ticks() - before < 20
    assert clients[0].ask_soon(bench, "INST:SEL?") == '"a"'
    assert bench.end() == 0


def test_one_control_address_twice(tmp_path):
    file = tmp_path / "rig.ini"
    file.write_text("[rig]\ncontrol = unix:s\ncontrol = unix:s\n[encoder a]\nmodel = f3668\n"
                    "wire = slcan\n")
    assert "in use already" in run_refused(1, "run", file)
    assert not (tmp_path / "s").exists()


def test_what_dead_rigs_left_behind_is_used_again(rig, tmp_path):
    environment = os.environ | {"XDG_RUNTIME_DIR": str(tmp_path)}
    text = "[rig]\nname = same\n[encoder a]\nmodel = f3668\nwire = slcan\n"
    for _ in range(3):
        for one in [rig(text, env=environment) for _ in range(3)]:
            one.process.kill()
            one.process.wait(PATIENCE_S)
    left = sorted(path.name for path in (tmp_path / "drehgeber").iterdir())
    assert left == ["same-2.sock", "same-3.sock", "same.sock"]


def test_an_erased_eeprom_is_not_damaged(rig):
    client = rig(ON_A_LINE).client()
    assert client.error("POW OFF;:FAUL:SET EEPROM_UART;:FAUL:SET EEPROM_TYPE") == 0
    assert client.ask("FAUL:ACT?").count("eeprom_") == 2
    assert client.error("NVM:ERAS;:POW ON") == 0
    assert client.ask("FAUL:ACT?") == '""'


# --- traces -------------------------------------------------------------------------------------

def test_time_in_a_trace_never_goes_back(rig, tmp_path):
    """Requests that come in at once wait for each other's answers."""
    bench = rig("[encoder a]\nmodel = f3668\nwire = slcan:can\ntrace = can.log\n")
    with serial.Serial(str(tmp_path / "can"), timeout=PATIENCE_S) as port:
        port.write(b"S5\rO\r" + b"t63F84004600000000000\r" * 200)
        answers = b""
        while answers.count(b"t5BF8") < 200:
            got = port.read_until(b"\r")
            assert got, answers
            answers += got
    assert bench.end() == 0
    times = [float(line[1:line.index(")")]) for line in (tmp_path / "can.log").open()]
    assert len(times) >= 400 and times == sorted(times)
