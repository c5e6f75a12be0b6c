# SPDX-License-Identifier: MIT
"""Start, end, and the memory that outlives both."""
import os
import resource
import signal
import socket
import stat
import subprocess

import pytest
import serial

from hiperface_master import EncoderError, FieldStatus
from rig import MULTITURN, PATIENCE_S, PROGRAM, SINGLETURN, assert_one_line, run_refused


@pytest.mark.parametrize("signal_number", [signal.SIGTERM, signal.SIGINT])
def test_signals_end_it(start, signal_number):
    encoder = start()
    encoder.master().read_position()
    assert encoder.end(signal_number) == 0
    assert encoder.out.so_far() == []


@pytest.mark.parametrize("descriptors, what", [(4, "event loop"), (5, "timer")])
def test_without_descriptors_it_says_so(descriptors, what):
    def limit():
        resource.setrlimit(resource.RLIMIT_NOFILE, (descriptors, descriptors))
    line = run_refused(1, "run", MULTITURN, "--pty", preexec_fn=limit)
    assert line == f"drehgeber: no {what}: Too many open files"


def test_link(start, tmp_path):
    link = tmp_path / "encoder"
    encoder = start(wire=[f"--pty={link}"])
    assert link.is_symlink() and os.path.realpath(link).startswith("/dev/pts/")
    encoder.path = str(link)
    assert encoder.master().read_position() == 0
    encoder.end()
    assert not os.path.lexists(link)


def test_link_left_behind_is_replaced(start, tmp_path):
    link = tmp_path / "encoder"
    start(wire=[f"--pty={link}"]).end(signal.SIGKILL)
    assert link.is_symlink()
    encoder = start(wire=[f"--pty={link}"])
    encoder.path = str(link)
    assert encoder.master().read_position() == 0


def test_link_of_a_running_encoder_is_refused(start, tmp_path):
    link = tmp_path / "encoder"
    encoder = start(wire=[f"--pty={link}"])
    line = run_refused(1, "run", MULTITURN, f"--pty={link}")
    assert str(encoder.process.pid) in line
    encoder.path = str(link)
    assert encoder.master().read_position() == 0


def test_link_of_a_restarted_encoder_is_refused(start, tmp_path):
    link = tmp_path / "encoder"
    start(wire=[f"--pty={link}"]).end(signal.SIGKILL)
    encoder = start(wire=[f"--pty={link}"])
    assert str(encoder.pid) in run_refused(1, "run", MULTITURN, f"--pty={link}")


def test_link_whose_pty_is_another_encoders_is_replaced(start, tmp_path):
    links = [tmp_path / "a", tmp_path / "b"]
    other = start(wire=[f"--pty={links[1]}"])
    links[0].symlink_to(os.readlink(links[1]))
    encoder = start(wire=[f"--pty={links[0]}"])
    for running, link in ((encoder, links[0]), (other, links[1])):
        running.path = str(link)
        assert running.master().read_position() == 0


def test_closed_stdout_does_not_reach_the_memory(nvm):
    command = ["sh", "-c", 'exec "$0" "$@" >&-', str(PROGRAM), "run", MULTITURN, "--pty", "--nvm", str(nvm)]
    ended = subprocess.run(command, stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                           timeout=PATIENCE_S)
    assert ended.returncode == 1 and len(ended.stderr.splitlines()) == 1, ended.stderr
    with open(nvm, "rb") as image:
        headers = image.read(24)
    assert headers[:4] == b"dge1" and headers[:12] == headers[12:]


def test_link_does_not_replace_a_file(tmp_path):
    link = tmp_path / "precious"
    link.write_text("precious")
    line = run_refused(1, "run", MULTITURN, f"--pty={link}")
    assert str(link) in line
    assert link.read_text() == "precious"


def test_notify_socket(start, tmp_path):
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as notify:
        notify.bind(str(tmp_path / "notify"))
        notify.settimeout(PATIENCE_S)
        encoder = start(env={**os.environ, "NOTIFY_SOCKET": str(tmp_path / "notify")})
        assert "READY=1" in notify.recv(4096).decode().splitlines()
        encoder.end()


def patient_master(encoder, **options):
    """It waits as long as a busy disk makes it; test_slow_disk looks how long that may be."""
    return encoder.master(grace_s=PATIENCE_S, **options)


def test_acknowledged_data_survives_kill(start, nvm):
    encoder = start("--nvm", nvm, "--serial", "246813579")
    master = patient_master(encoder)
    master.create_field(0, FieldStatus(64, code_number=1))
    master.save_data(0, 3, b"drive parameters")
    master.modify_access_code(2, 0x55, 0x66)
    master.assign_address(0x4C)
    master.set_position(123456)
    master.increment_counter()
    encoder.end(signal.SIGKILL)

    master = patient_master(start("--nvm", nvm), address=0x4C)
    assert master.read_data(0, 0, 20) == b"\xff" * 3 + b"drive parameters" + b"\xff"
    assert master.available_memory() == (1792 - 64, 1)
    assert master.read_counter() == 1
    assert master.read_position() == 123456
    assert master.identity().serial_number == "246813579"
    master.modify_access_code(2, 0x66, 0x55)


def test_kill_at_any_moment(start, nvm):
    value, rounds = 0, 5
    for number in range(rounds):
        encoder = start("--nvm", nvm, "--set", "pace=0")
        master = patient_master(encoder)
        assert master.read_status() == 0
        assert master.read_counter() in (value, value + 1)  # the last one was not acknowledged
        value = master.read_counter()
        for _ in range(3):
            master.increment_counter()
            value += 1
        master.send(bytes.fromhex("40 47 07"))
        master.receive(1, 0.003 * number)
        encoder.end(signal.SIGKILL)
    assert value >= 3 * rounds


def test_without_memory_state_is_lost(start):
    encoder = start()
    patient_master(encoder).increment_counter()
    encoder.end()
    assert start().master().read_counter() == 0


def test_memory_is_private(start, nvm):
    start("--nvm", nvm)
    assert stat.S_IMODE(nvm.stat().st_mode) == 0o600


def test_memory_in_use(start, nvm):
    first = start("--nvm", nvm)
    line = run_refused(1, "run", MULTITURN, "--pty", "--nvm", nvm)
    assert str(first.pid) in line and str(nvm) in line
    assert first.master().read_position() == 0
    first.end(signal.SIGKILL)
    assert patient_master(start("--nvm", nvm)).read_position() == 0


@pytest.mark.parametrize("content", [b"[section]\nkey = value\n", bytes(range(256)) * 64],
                         ids=["text", "binary"])
def test_foreign_file_is_left_alone(nvm, content):
    nvm.write_bytes(content)
    before = nvm.stat()
    line = run_refused(1, "run", MULTITURN, "--pty", "--nvm", nvm)
    assert str(nvm) in line
    after = nvm.stat()
    assert nvm.read_bytes() == content
    assert (after.st_mtime_ns, after.st_mode) == (before.st_mtime_ns, before.st_mode)


def test_truncated_image_loses_data_openly(start, nvm):
    encoder = start("--nvm", nvm, "--set", "pace=0")
    master = patient_master(encoder)
    for number in range(14):
        master.create_field(number, FieldStatus(128))
        master.save_data(number, 0, bytes([number]) * 128)
    encoder.end()
    os.truncate(nvm, nvm.stat().st_size - 300)
    encoder = start("--nvm", nvm, "--set", "pace=0")
    assert_one_line(encoder, str(nvm))
    master = patient_master(encoder)
    lost = 0
    for number in range(14):
        try:
            assert master.read_data(number, 0, 128) == bytes([number]) * 128
        except EncoderError as error:
            assert error.code == 0x03  # 5.1.3.4, during operation
            lost += 1
    assert lost > 0


def test_truncated_image_is_a_damaged_memory(start, nvm):
    start("--nvm", nvm).end()
    os.truncate(nvm, nvm.stat().st_size // 50)
    encoder = start("--nvm", nvm)
    assert_one_line(encoder, str(nvm))
    master = patient_master(encoder)
    with pytest.raises(EncoderError) as refused:
        master.read_position()
    assert refused.value.code == 0x02 and master.warning
    assert 0x06 in master.read_all_status()  # 5.1.3.6


def test_memory_of_another_model(start, nvm):
    start("--nvm", nvm, model=SINGLETURN).end()
    before = nvm.read_bytes()
    line = run_refused(1, "run", MULTITURN, "--pty", "--nvm", nvm)
    assert str(nvm) in line
    assert nvm.read_bytes() == before


def test_memory_of_another_serial_number(start, nvm):
    start("--nvm", nvm, "--serial", "111111111").end()
    line = run_refused(1, "run", MULTITURN, "--pty", "--nvm", nvm, "--serial", "222222222")
    assert str(nvm) in line and "serial number" in line
    assert start("--nvm", nvm, "--serial", "111111111").master().read_position() == 0


def test_no_such_directory(tmp_path):
    missing = tmp_path / "none" / "encoder.nvm"
    assert str(missing) in run_refused(1, "run", MULTITURN, "--pty", "--nvm", missing)


def test_damaged_memory_is_found(start, nvm):
    start("--nvm", nvm, "--serial", "897867564").end()
    image = nvm.read_bytes()
    assert b"897867564" in image
    nvm.write_bytes(image.replace(b"897867564", b"997867564"))
    # The serial number shares its check sum with the type code: 05h and 06h (5.1.3.5).
    master = patient_master(start("--nvm", nvm))
    assert master.read_position() == 0 and master.warning
    with pytest.raises(EncoderError) as refused:
        master.identity()
    assert refused.value.code == 0x05 and master.warning
    first = master.read_status()
    assert master.warning
    assert {first, master.read_status()} == {0x05, 0x06}
    assert not master.warning  # the reply that empties the stack carries it no more
    assert master.read_status() == 0


def test_no_room_at_first_start(start, nvm):
    def no_room():
        resource.setrlimit(resource.RLIMIT_FSIZE, (0, resource.RLIM_INFINITY))

    line = run_refused(1, "run", MULTITURN, "--pty", "--nvm", nvm, preexec_fn=no_room)
    assert str(nvm) in line
    assert patient_master(start("--nvm", nvm)).read_counter() == 0


def test_disk_full_while_running(start, nvm):
    encoder = start("--nvm", nvm)
    master = patient_master(encoder)
    master.create_field(0, FieldStatus(16))
    master.save_data(0, 0, b"before")
    encoder.limit_file_size(0)
    for _ in range(3):
        with pytest.raises(EncoderError) as refused:
            master.save_data(0, 0, b"during")
        assert refused.value.code == 0x05
    assert_one_line(encoder, str(nvm))
    assert master.read_position() == 0

    encoder.limit_file_size(resource.RLIM_INFINITY)
    assert master.read_data(0, 0, 6) in (b"before", b"during")
    master.save_data(0, 0, b"after!")
    encoder.errors.so_far()  # it may say that the disk is back
    encoder.end(signal.SIGKILL)
    assert patient_master(start("--nvm", nvm)).read_data(0, 0, 6) == b"after!"


def lose(nvm, tmp_path, how):
    """What can happen to a file while an encoder uses it."""
    if how == "deleted":
        nvm.unlink()
    else:
        (tmp_path / "other").write_bytes(nvm.read_bytes())
        os.replace(tmp_path / "other", nvm)


@pytest.mark.parametrize("how", ["deleted", "replaced"])
def test_a_file_lost_while_running_takes_no_writes(start, nvm, tmp_path, how):
    encoder = start("--nvm", nvm)
    master = patient_master(encoder)
    master.create_field(0, FieldStatus(16))
    master.save_data(0, 0, b"before")
    lose(nvm, tmp_path, how)
    for _ in range(3):
        with pytest.raises(EncoderError) as refused:
            master.save_data(0, 0, b"during")
        assert refused.value.code == 0x05
    assert_one_line(encoder, str(nvm), how, "05h")
    assert master.read_data(0, 0, 6) == b"before"
    assert master.read_position() == 0
    encoder.end()
    if how == "replaced":  # and the other file is as it was
        assert patient_master(start("--nvm", nvm)).read_data(0, 0, 6) == b"before"


def test_a_file_cut_off_while_running_is_made_whole(start, nvm):
    encoder = start("--nvm", nvm)
    master = patient_master(encoder)
    master.create_field(0, FieldStatus(16))
    master.save_data(0, 0, b"before")
    os.truncate(nvm, 0)
    master.save_data(0, 6, b"after")
    assert_one_line(encoder, str(nvm), "truncated to 0 bytes")
    encoder.end(signal.SIGKILL)
    assert patient_master(start("--nvm", nvm)).read_data(0, 0, 11) == b"beforeafter"


def test_a_node_without_its_file_says_what_it_answers(start, nvm):
    encoder = start("--nvm", nvm, model="f3668", wire=["--slcan"])
    nvm.unlink()
    with serial.Serial(encoder.path.rpartition("/")[0], timeout=PATIENCE_S) as adapter:
        adapter.write(b"S5\rO\rt63F82310100173617665\r")  # 1010h:1, "save"
        while not (answer := adapter.read_until(b"\r")).startswith(b"t5BF") and answer:
            pass
    assert answer == b"t5BF88010100100000606\r"
    assert_one_line(encoder, str(nvm), "deleted", "abort 06060000h")
