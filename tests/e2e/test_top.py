# SPDX-License-Identifier: MIT
"""drehgeber top in a real terminal: what its screen says is what the control plane says."""
import itertools
import os
import pty
import re
import signal
import socket
import subprocess
import sys
import threading
import time

import pytest

from rig import PATIENCE_S, PROGRAM, REPOSITORY, free_port, run, run_refused

sys.path.insert(0, str(REPOSITORY / "tools/python"))
import drehgeber  # noqa: E402

FOUR = """
[rig]
name = four
control = unix:panel.sock
[shaft main]
[shaft pitch]
driver = main
ratio = -1:10
[encoder hf]
model = s3684-rs485
wire = pty
[encoder co]
model = f3668
wire = slcan
shaft = pitch
[encoder ib]
model = ocd-ib-k3
wire = modbus:127.0.0.1:0
[encoder bi]
model = s3684-biss
wire = sim
"""
MANY = "[rig]\ncontrol = unix:panel.sock\n[bus b0]\nwire = pty\n[bus b1]\nwire = pty\n" + "".join(
    f"[encoder e{n}]\nmodel = s3684-rs485\nbus = b{n // 20}\naddress = {0x40 + n % 20}\n"
    for n in range(40))
numbers = itertools.count()


class Panel:
    """A tmux server with one window in which top runs, then a shell says how it has ended."""

    def __init__(self, command: str, width: int = 100, height: int = 30, term: str = ""):
        self.name = f"drehgeber-{os.getpid()}-{next(numbers)}"
        shell = f'{command}; echo "status $?"; stty -a; exec sleep 60'
        if term:
            shell = f"export TERM={term}; {shell}"
        # Whoever has tmux around this test keeps it out of here.
        self.environment = {k: v for k, v in os.environ.items() if k not in ("TMUX", "TMUX_PANE")}
        self.tmux("start-server", ";", "set-option", "-g", "default-terminal", "tmux-256color", ";",
                  "new-session", "-d", "-x", str(width), "-y", str(height), shell)

    def tmux(self, *arguments: str) -> str:
        return subprocess.run(["tmux", "-f", "/dev/null", "-L", self.name, *arguments], text=True,
                              env=self.environment, stdout=subprocess.PIPE, timeout=PATIENCE_S,
                              check=True).stdout

    def screen(self) -> str:
        return self.tmux("capture-pane", "-p")

    def wait(self, *patterns: str) -> str:
        """The screen, as soon as all of this is on it."""
        deadline = time.monotonic() + PATIENCE_S
        while True:
            screen = self.screen()
            missing = [p for p in patterns if not re.search(p, screen, re.MULTILINE)]
            if not missing:
                return screen
            assert time.monotonic() < deadline, f"no {missing} in\n{screen}"
            time.sleep(0.05)

    def wait_gone(self, pattern: str) -> str:
        deadline = time.monotonic() + PATIENCE_S
        while re.search(pattern, self.screen(), re.MULTILINE):
            assert time.monotonic() < deadline, f"{pattern} in\n{self.screen()}"
            time.sleep(0.05)
        return self.screen()

    def keys(self, *keys: str):
        self.tmux("send-keys", *keys)

    def pid(self) -> int:
        """Of top itself: the only child of the window's shell."""
        shell = self.tmux("display-message", "-p", "#{pane_pid}").strip()
        with open(f"/proc/{shell}/task/{shell}/children") as children:
            return int(children.read().split()[0])

    def close(self):
        subprocess.run(["tmux", "-L", self.name, "kill-server"], env=self.environment,
                       stderr=subprocess.DEVNULL, timeout=PATIENCE_S, check=False)


@pytest.fixture
def panel():
    """Start top in a terminal: panel(ADDRESS)."""
    running = []

    def begin(address, command=None, **options) -> Panel:
        running.append(Panel(command or f"{PROGRAM} top {address}", **options))
        return running[-1]

    yield begin
    for one in running:
        one.close()


@pytest.fixture
def file(tmp_path):
    (tmp_path / "four.ini").write_text(FOUR)
    return tmp_path / "four.ini"


@pytest.fixture
def four(file, monkeypatch):
    """A rig of four encoders on two shafts at rest, its address at .address."""
    monkeypatch.setenv("DREHGEBER", PROGRAM)
    with drehgeber.run(file, folder=file.parent) as rig:
        rig.address = f"unix:{file.parent}/panel.sock"
        yield rig


def row(screen: str, name: str) -> str:
    """The line of an encoder in the table."""
    return next(line for line in screen.splitlines() if line.startswith(f"{name} "))


def eventually(ask, wanted):
    deadline = time.monotonic() + PATIENCE_S
    while ask() != wanted:
        assert time.monotonic() < deadline, (ask(), wanted)
        time.sleep(0.05)


def test_what_is_to_be_seen(panel, four):
    main = four.encoders["hf"].shaft
    main.position = 2 * 360 + 90
    top = panel(four.address, width=130)
    screen = top.wait(r"90\.000 deg.* 27(9\.000|8\.999) deg", r"2 turns .* -1 turns",
                      r"0\.000 rpm", r"^bi .* idle +\d", r"^ib .* position ")
    assert "panel" in screen.splitlines()[0] and four.address in screen.splitlines()[0]
    assert re.search(r"^\|   \+ - @ ", screen, re.MULTILINE), screen  # to the right: 90 degrees
    for name, mode in ("hf", "on"), ("co", "preoperational"), ("ib", "position"), ("bi", "idle"):
        state = four.encoders[name].state(raw=True)
        line = row(screen, name)
        assert state["mode"] == mode
        for part in four.encoders[name].model, four.encoders[name].wire, mode, state["position"]:
            assert part in line, (part, line)
    assert "BUS:off ERR:blink" in row(screen, "co")
    assert re.search(r"UL:on RC:on BA:\w+ RD:off", row(screen, "ib"))
    top.wait(r"^bi .* \d+ +-$")  # frames per second
    four.encoders["hf"].shaft.velocity = 60
    top.wait(r"60\.000 rpm|59\.999 rpm", r"-6\.000 rpm|-5\.999 rpm")


def test_the_only_one_that_runs(panel, start, tmp_path):
    start("--shaft", "450DEG", env={**os.environ, "XDG_RUNTIME_DIR": str(tmp_path)})
    top = panel(None, f"XDG_RUNTIME_DIR={tmp_path} {PROGRAM} top")
    top.wait(r" 90\.000 deg", " 1 turns", "^s3684-rs485 s3684-rs485 .* on +81920 ")


def test_frames_of_the_selected_encoder(panel, four):
    top = panel(four.address)
    top.wait("^bi .* idle")
    top.keys("End")
    top.wait(r"4/4", r"^\d+\.\d+ > position 0:0 nERR 1 nWARN 1 .*CRC ok")
    top.keys("Home")
    top.wait(r"1/4")
    assert "CRC ok" not in top.screen()


def test_keys_turn_the_shaft(panel, four):
    main = four.encoders["hf"].shaft
    top = panel(four.address)
    top.wait(r" 0\.000 deg", "^bi .* idle")
    for keys, angle in (["Right"] * 3, 3), (["Left"], 2), (["L", "L"], 22), (["H", "h", "l"], 12), \
            (["S-Right"], 22), (["S-Left", "S-Left"], 2):
        top.keys(*keys)
        eventually(lambda: main.position, angle)
        top.wait(rf" {angle}\.000 deg")
    top.keys("Down", "Down", "Right")  # a third encoder, the same shaft
    eventually(lambda: main.position, 3)

    top.keys("+", "+")
    eventually(lambda: main.velocity, 20)
    top.keys("-", "-", "-")
    eventually(lambda: main.velocity, -10)
    top.keys("Space")
    eventually(lambda: main.velocity, 0)
    top.keys("Up", "+")  # the geared one
    top.wait("Settings conflict;a geared shaft is turned by its driver")
    top.wait_gone("Settings conflict")


def test_a_defect_comes_and_goes(panel, four):
    co = four.encoders["co"]
    catalogue = [fault["name"] for fault in co.faults()]
    wanted = catalogue.index("temperature_high")
    top = panel(four.address, width=130)
    top.wait("^co .* preoperational")
    top.keys("Down", "f")
    screen = top.wait("co: enter sets or clears", *catalogue[:3], "eeprom_saved")
    assert co.faults()[0]["effect"][:40] in screen
    top.keys(*["Down"] * wanted, "Enter")
    top.wait(r"\* temperature_high")
    eventually(lambda: co.ask("FAUL:ACT?"), '"temperature_high"')
    top.keys("Escape")
    top.wait(r"^co .* ERR:(?!off)\w+ .* 4200 .* temperature_high$")
    assert co.state()["errors"] == "4200"

    top.keys("f")
    top.wait(r"\* temperature_high")
    top.keys(*["Down"] * wanted, "Enter")
    eventually(lambda: co.ask("FAUL:ACT?"), '""')
    top.keys("Down", "Enter", "x")  # the next one; any other key closes
    top.wait_gone("enter sets or clears")
    eventually(lambda: co.ask("FAUL:ACT?"), f'"{catalogue[wanted + 1]}"')
    top.wait(rf"^co .* {catalogue[wanted + 1]}$")  # and no longer the one before
    assert "temperature_high" not in row(top.screen(), "co")
    top.keys("c")
    eventually(lambda: co.ask("FAUL:ACT?"), '""')
    top.wait(r"^co .* (-|\d+) +-$")  # frames per second, no faults


def test_power(panel, four):
    bi = four.encoders["bi"]
    top = panel(four.address)
    top.wait("^bi .* idle")
    top.keys("End", "p")
    top.wait("^bi .* off +- ", "power OFF")
    assert bi.state()["power"] == 0
    top.keys("p")
    top.wait("^bi .* idle", "power on")
    assert bi.state()["power"] == 1


def test_sizes(panel, four):
    top = panel(four.address, width=80, height=24)
    screen = top.wait("^bi .* idle", "^co .*slcan +BUS:off ERR:blink .*preoperational ")
    assert screen.splitlines()[23].endswith("q") and "NAME" in screen and "~" not in row(screen, "hf")
    top.tmux("resize-window", "-x", "39", "-y", "24")
    top.wait("window too small: expected 40x10")
    top.tmux("resize-window", "-x", "40", "-y", "9")
    top.wait("window too small: expected 40x10")
    top.tmux("resize-window", "-x", "10", "-y", "3")
    top.wait("window to~")
    top.tmux("resize-window", "-x", "160", "-y", "60")
    screen = top.wait(r"^co .*slcan:/dev/pts/\d+/63 +BUS:off ERR:blink +preoperational ")
    assert len(screen.splitlines()) == 60
    top.keys("?")
    top.wait("turn its shaft by 1 degree")
    top.keys("x")
    top.wait_gone("turn its shaft by 1 degree")


def test_forty_columns(panel, four):
    """Ten lines: the shaft, the table, the selected encoder, the keys; and all of it works."""
    co = four.encoders["co"]
    top = panel(four.address, width=40, height=10)
    screen = top.wait(r"^main +0 turns 0\.000 deg +0\.000 rpm$", "^NAME +MODE +POSITION +ERRORS$",
                      "^co +preoperational +0 +-$", "^bi +idle ")
    lines = screen.splitlines()
    assert len(lines) == 10 and "1/4" in lines[7] and lines[9].endswith("q")
    four.encoders["hf"].shaft.position = -(3 * 360 + 90)
    top.wait(r"^main +-4 turns 270\.000 deg +0\.000 rpm$")
    four.encoders["hf"].shaft.position = 0
    top.keys("Down", "+")  # the geared one
    top.wait(r"Settings conflict;a geared shaft is \w*~$")  # where the keys were
    top.keys("f")
    top.wait("co: enter sets or clears", "led_current_high")
    top.keys("Down", "Enter", "Escape")
    eventually(lambda: co.ask("FAUL:ACT?"), '"temperature_high"')
    top.wait("^co +preoperational +0 +4200$", r"^BUS:\w+ ERR:\w+ +temperature_high$")
    top.keys("?")
    screen = top.wait("^up down, j k +select an encoder; page", "^q +leave$")
    assert len(screen.splitlines()) == 10
    top.keys("x")
    top.wait("^NAME")
    top.tmux("resize-window", "-x", "60", "-y", "16")
    top.wait("last frames on this wire", "^main|^pitch")


def test_a_large_window_shows_more(panel, four):
    """Of a shaft, of the state, and more frames."""
    four.encoders["hf"].shaft.position = 360 + 90
    top = panel(four.address, width=200, height=60)
    top.wait("^bi .* idle")
    top.keys("End")
    top.wait(r"^NAME .* SHAFT +ANGLE +MORE ", r"^hf .* main +1:090\.000 +replies=0 ",
             r"^co .* pitch +-1:315\.000 +sent=")
    deadline = time.monotonic() + PATIENCE_S
    while top.screen().count(" > position ") < 25:
        assert time.monotonic() < deadline, top.screen()
        time.sleep(0.1)
    narrow = panel(four.address, width=100, height=30)
    screen = narrow.wait("^bi .* idle")
    assert "SHAFT" not in screen and "MORE" not in screen


@pytest.mark.parametrize("setting, wanted", [("", True), ("NO_COLOR=", True), ("NO_COLOR=1", False)])
def test_colours_are_as_wanted(panel, four, setting, wanted):
    top = panel(None, f"env {setting} {PROGRAM} top {four.address}")
    top.wait("^ib .*UL:on")
    codes = re.findall(r"\x1b\[([\d;]*)m", top.tmux("capture-pane", "-p", "-e"))
    assert any(re.search(r"(^|;)3[0-7](;|$)", code) for code in codes) == wanted
    assert any("1" in code.split(";") for code in codes)  # bold, where it says something


def test_forty_encoders(panel, tmp_path, monkeypatch):
    monkeypatch.setenv("DREHGEBER", PROGRAM)
    (tmp_path / "many.ini").write_text(MANY)
    with drehgeber.run(tmp_path / "many.ini", folder=tmp_path):
        top = panel(f"unix:{tmp_path}/panel.sock", width=80, height=24)
        top.wait(r"^e0 .* on ", "1/40")
        assert not re.search("^e39 ", top.screen(), re.MULTILINE)
        top.keys("End")
        top.wait(r"^e39 .* on ", "40/40")
        top.keys("PPage")
        screen = top.wait(r"3[0-5]/40", r"^e\d+ .* on ")
        assert not re.search("^e0 ", screen, re.MULTILINE)
        top.keys("Home", *["Down"] * 25)
        top.wait(r"^e25 .* on ", "26/40")


@pytest.mark.parametrize("kind", ["unix", "tcp"])
def test_the_rig_goes_and_comes_back(panel, file, monkeypatch, kind):
    monkeypatch.setenv("DREHGEBER", PROGRAM)
    address = f"unix:{file.parent}/panel.sock"
    if kind == "tcp":
        address = f"tcp:localhost:{free_port()}"
        file.write_text(FOUR.replace("unix:panel.sock", address))
    with drehgeber.run(file, folder=file.parent):
        top = panel(address)
        top.wait("^bi .* idle")
        top.keys("End")
        top.wait("4/4")
    top.wait("no connection, trying again: (Connection|No such)")
    top.keys("Right")  # into nothing, and not kept
    with drehgeber.run(file, folder=file.parent) as rig:
        top.wait_gone("no connection")
        top.wait("^bi .* idle", "4/4", r" 0\.000 deg")
        assert rig.encoders["bi"].shaft.position == 0
        top.keys("Right")
        eventually(lambda: rig.encoders["bi"].shaft.position, 1)


def test_a_rig_that_does_not_answer(panel, four):
    top = panel(four.address)
    top.wait("^bi .* idle")
    os.kill(four.pid, signal.SIGSTOP)
    try:
        top.wait("no answer for [1-9] s")
        top.keys("Right")
        top.keys("?")
        top.wait("turn its shaft by 1 degree")  # the screen goes on
        top.wait("no connection, trying again: no answer")
    finally:
        os.kill(four.pid, signal.SIGCONT)
    top.keys("x")
    top.wait_gone("no answer|no connection")
    top.wait(r" 0\.000 deg")
    assert four.encoders["hf"].shaft.position == 0
    top.keys("Right")
    eventually(lambda: four.encoders["hf"].shaft.position, 1)


@pytest.mark.parametrize("end", ["q", "C-c", signal.SIGTERM, signal.SIGHUP])
def test_the_terminal_is_as_before(panel, four, end):
    top = panel(four.address)
    top.wait("^bi .* idle")
    if isinstance(end, str):
        top.keys(end)
    else:
        os.kill(top.pid(), end)
    screen = top.wait("^status 0$", r"[^-]icanon", r"[^-]echo ", r"[^-]icrnl", r"[^-]onlcr")
    assert "NAME" not in screen  # the screen from before is back
    assert top.tmux("display-message", "-p", "#{cursor_flag} #{alternate_on}").strip() == "1 0"


def test_a_dead_terminal(four):
    """Its other end is closed: top ends, too."""
    master, slave = pty.openpty()
    environment = {**os.environ, "TERM": "xterm"}
    with subprocess.Popen([PROGRAM, "top", four.address], stdin=slave, stdout=slave,
                          stderr=subprocess.PIPE, env=environment) as process:
        os.close(slave)
        assert os.read(master, 10)
        os.close(master)
        assert process.wait(PATIENCE_S) == 1
        assert b"the terminal has gone" in process.stderr.read()


def test_garbage_is_no_answer(panel, tmp_path):
    """Whatever listens there, the screen lives and says so."""
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(f"{tmp_path}/sock")
        listener.listen(9)
        listener.settimeout(PATIENCE_S)
        top = panel(f"unix:{tmp_path}/sock")

        def answer(data: bytes):
            line, _ = listener.accept()
            with line:
                line.settimeout(PATIENCE_S)
                line.recv(4096)
                try:
                    line.sendall(data)
                    while line.recv(4096):
                        pass
                except OSError:
                    pass

        answer(b'-350,"too many clients"\n')
        top.wait("trying again: -350")
        answer(bytes(range(256)) * 4)
        top.wait("trying again: ")
        answer(b"x" * 2**23)  # a line without an end
        top.wait("trying again: Message too long")
        # Right, but for everything behind the mark.
        half = threading.Thread(target=answer, args=(
            b'1999.0;"a","a b""c";"s"\n1999.0;"m"\n1999.0;;;\n1999.0;power=,=,mode=x;"\n'
            b'1999.0\n1999.0;1;2\n1999.0;nan;-1\n',))
        half.start()
        top.wait(r"^a ", 'a b"c')
        top.keys("f", "Enter", "x", "Right", "+", "p", "c", "q")
        top.wait("^status 0$")
        half.join(PATIENCE_S)


def test_without_a_terminal(four):
    assert "top needs a terminal" in run_refused(1, "top", four.address)


def test_wrong_words(tmp_path):
    assert "no connection" in run_refused(1, "top", f"unix:{tmp_path}/nobody")
    assert "unix:PATH" in run_refused(2, "top", "nonsense")
    assert "superfluous" in run_refused(2, "top", "unix:a", "b")
    assert "--node" in run_refused(2, "top", "--node", "3")
    assert "drehgeber top [ADDRESS]" in run("--help").stdout


@pytest.mark.parametrize("term", ["dumb", "nonsense", "''"])
def test_terminals_without_a_cursor(panel, four, term):
    screen = panel(four.address, term=term, width=200).wait("^status 2$")
    assert "not a terminal with a cursor" in screen
