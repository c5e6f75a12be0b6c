# SPDX-License-Identifier: MIT
"""What `drehgeber top` draws, cell by cell, of a control plane that always says the same.

tests/golden/screens has the screens, which somebody has read; `DREHGEBER_UPDATE=1 pytest test_top_screens.py`
writes them anew, and the difference is to be read."""
import os
import re
import socket
import threading
import time

import pytest

from rig import PATIENCE_S, PROGRAM, REPOSITORY
from test_top import Panel

SCREENS = REPOSITORY / "tests/golden/screens"
UPDATE = "DREHGEBER_UPDATE" in os.environ

# name: angle in degrees, speed in rpm; nobody sits on the last one
SHAFTS = {"main": ("810.000999", "60.000"), "pitch": ("-405.500000", "-6.001"), "third": ("179.9", "0.000"),
          "fourth": ("0.000000", "0.000"), "a_shaft_with_a_long_name": ("359.999999", "0.5"), "bare": ("1", "1")}
# name: model, wire, shaft, state, faults; of those that tell no frames nobody knows how many a second
ENCODERS = {
    "hf": ("s3684-rs485", "pty:/dev/pts/7", "main",
           "power=1,mode=on,position=81920,leds=-,errors=-,frames=7,replies=0,damaged=3,wire_up=1,wire_late=0", ""),
    "co": ("f3668", "slcan:/dev/pts/8/63", "pitch",
           "power=1,mode=preoperational,position=-12345,leds=bus:blink/err:on,errors=4200 8130,frames=0,sent=1,"
           "malformed=0,late_sync=0,node=63,bus_off=0,causes=00000000,shared_ids=-,wire_up=0,wire_kbaud=250",
           '"temperature_high","led_current_high"'),
    "ib": ("ocd-ib-k3", "modbus:127.0.0.1:35919/0", "third",
           "power=0,mode=off,position=-,leds=UL:off/RC:off/BA:on/RD:on,errors=-,frames=1,wire_up=1", '"line_cut"'),
    "one_with_a_name_that_is_too_long_for_it": (
        "s3684-biss", "sim:" + "x" * 60, "a_shaft_with_a_long_name",
        "power=1,mode=idle,position=16777215,leds=-,errors=1 2 3 4 5 6 7 8 9 10 11 12,frames=9,"
        + ",".join(f"number_{i}={i * 1000}" for i in range(20)), ",".join(f'"fault_{i:02}"' for i in range(12))),
    **{f"e{i}": ("ssi-13", "sim:", "fourth", f"power=1,mode=ready,position={i},leds=-,errors=-,wire_up=1", "")
       for i in range(1, 17)},
}
FRAMES = [f"{i}.{i:06} > frame {i} " + "0123456789 " * (i % 12) for i in range(1, 33)]
FAULTS = [(f"fault_{i:02}", "WORLD", f"cause {i}: " + "abcde " * (i % 9), f"effect {i}: " + "vwxyz " * (i % 20), "5.2")
          for i in range(16)] + [("led_current_high", "WIRE", 'a ""quoted"" cause; with, signs', "effect", "no. 1")]


def quoted(texts):
    return ",".join(f'"{text}"' for text in texts)


class Rig:
    """Answers what top asks, each time the same; .done has what it was told to do."""

    def __init__(self, path):
        self.done = []
        self.asked = threading.Event()
        self.answers = threading.Event()  # as long as it is set
        self.answers.set()
        self.listener = socket.socket(socket.AF_UNIX)
        self.listener.bind(str(path))
        self.listener.listen()
        self.thread = threading.Thread(target=self.serve)
        self.thread.start()

    def serve(self):
        try:
            line = self.listener.accept()[0]
        except OSError:
            return
        with line, line.makefile() as questions:
            for question in questions:
                self.asked.set()
                self.answers.wait(PATIENCE_S)
                answer = self.answer(question.rstrip("\n"))
                if answer is None:
                    self.done.append(question.rstrip("\n"))
                    continue
                line.sendall(f"1999.0;{answer}\n".encode())

    def answer(self, question):
        if question == "SYST:VERS?;:INST:CAT?;:SHAF:CAT?":
            return quoted(ENCODERS) + ";" + quoted(SHAFTS)
        if question == "SYST:VERS?;:TIME?;:SYST:ERR:ALL?":
            return '12345.678901234;0,"No error"'
        asked = re.fullmatch(r'SYST:VERS\?;:INST:SEL "(\w+)";(.*)', question)
        if not asked:
            return None
        model, wire, shaft, state, faults = ENCODERS[asked[1]]
        return {
            "MOD?;WIRE?;:SHAF:NAME?": f'"{model}";"{wire}";"{shaft}"',
            ":STAT?;:FAUL:ACT?": state + ";" + (faults or '""'),
            ":SHAF:POS?;VEL?": ";".join(SHAFTS[shaft]),
            ":TRAC:LAST? 32": quoted(FRAMES),
            ":FAUL:CAT?": ",".join(f'"{n}",{k},"{c}","{e}","{h}"' for n, k, c, e, h in FAULTS),
        }[asked[2]]

    def close(self):
        self.listener.shutdown(socket.SHUT_RDWR)
        self.listener.close()
        self.thread.join(PATIENCE_S)


@pytest.fixture
def rig(tmp_path):
    one = Rig(tmp_path / "panel.sock")
    yield one
    one.answers.set()
    one.close()


@pytest.fixture
def top(rig, tmp_path):
    panel = Panel(f"cd {tmp_path}; {PROGRAM} top unix:./panel.sock", width=100, height=30)
    try:
        panel.wait(r"^hf .* 0 +-$")  # frames per second: counted
        yield panel
    finally:
        panel.close()


LOOKS = {"1": "bold", "2": "dim", "4": "underlined", "5": "blinks", "7": "reverse",
         "31": "red", "32": "green", "33": "yellow"}


def with_looks(text):
    """A screen in which '{dim red:word}' says what a word looks like."""
    looks, lines = set(), []
    for line in text.splitlines():
        runs = []
        for code, part in re.findall(r"(\x1b\[[\d;]*m|)([^\x1b]*)", re.sub(r"[\x0e\x0f]", "", line)):
            for number in re.findall(r"\d+", code) or (["0"] if code else []):
                if number in ("0", "39"):
                    looks = set() if number == "0" else looks - {"red", "green", "yellow"}
                elif number in LOOKS:
                    looks = looks | {LOOKS[number]}
            if runs and runs[-1][0] == looks:
                runs[-1] = (looks, runs[-1][1] + part)
            elif part:
                runs.append((looks, part))
        lines.append("".join(f"{{{' '.join(sorted(look))}:{part}}}" if look else part for look, part in runs))
    return "\n".join(lines)


def screen_of(top, looks):
    text = with_looks(top.tmux("capture-pane", "-p", "-e")) if looks else top.screen()
    return "\n".join(line.rstrip() for line in text.splitlines()) + "\n"


def assert_screen(top, name, looks=False):
    """The screen is the recorded one, at once or soon."""
    path = SCREENS / f"{name}.record"
    if UPDATE:
        time.sleep(1)
        path.write_text(screen_of(top, looks))
    deadline = time.monotonic() + PATIENCE_S / 2
    while (seen := screen_of(top, looks)) != path.read_text() and time.monotonic() < deadline:
        time.sleep(0.05)
    assert seen == path.read_text()


def assert_done(rig, wanted):
    """The rig was told this and nothing else, at once or soon."""
    deadline = time.monotonic() + PATIENCE_S
    while len(rig.done) < len(wanted) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert rig.done == wanted


def resize(top, width, height):
    top.tmux("resize-window", "-x", str(width), "-y", str(height))


def test_in_each_size(top):
    """Heights and widths on both sides of what changes the layout."""
    for width, height in (40, 10), (79, 15), (80, 16), (79, 23), (80, 24), (100, 33), (100, 34), (132, 44), (240, 64):
        resize(top, width, height)
        assert_screen(top, f"{width}x{height}")


def test_looks(top):
    """What is red, bold, dim or blinks; a row that is selected, one without power."""
    resize(top, 160, 34)
    assert_screen(top, "looks", looks=True)
    top.keys("Down")
    assert_screen(top, "looks-second", looks=True)
    top.keys("Down")
    assert_screen(top, "looks-third", looks=True)


def test_popups(rig, top):
    for width, height in (40, 10), (80, 12), (100, 30):
        resize(top, width, height)
        top.keys("?")
        assert_screen(top, f"keys-{width}x{height}")
        top.keys("x")
        top.wait_gone("faster or slower")
        top.keys("Home", "Down", "f")
        top.wait("fault_00")
        top.keys("Down", "Down", "Down")
        assert_screen(top, f"faults-{width}x{height}")
        top.keys("End")
        assert_screen(top, f"faults-end-{width}x{height}", looks=width == 100)
        top.keys("PPage", "Enter", "j", "k", "k", "Enter", "Home", "NPage", "Up", "Enter", "Escape")
        top.wait_gone("enter sets or clears")
    told = [f'INST:SEL "co";:FAUL:{what}' for what in ("SET fault_06", "SET fault_05", "SET fault_09")]
    assert_done(rig, 3 * told)


def test_the_selection_goes_and_the_table_follows(top):
    resize(top, 80, 24)
    for keys, name in (["Down"] * 7, "down"), (["NPage"], "page"), (["End"], "end"), (["Up"] * 5, "up"), \
            (["PPage", "PPage"], "back"), (["PPage", "PPage"], "home"), (["j", "j", "k"], "letters"):
        top.keys(*keys)
        assert_screen(top, f"selection-{name}")


def test_what_the_keys_say(rig, top):
    """To the encoder that is selected; a shaft that was turned is turned on from there."""
    top.keys("Right", "L", "h", "H", "+", "-", "Space", "p", "c", "Down", "Down", "p")
    wanted = [f'INST:SEL "hf";:{what}' for what in (
        "SHAF:POS 811.000999 DEG", "SHAF:POS 821.000999 DEG", "SHAF:POS 820.000999 DEG", "SHAF:POS 810.000999 DEG",
        "SHAF:VEL 10.000 RPM", "SHAF:VEL 0.000 RPM", "SHAF:STOP", "POW OFF", "FAUL:CLE")] + ['INST:SEL "ib";:POW ON']
    assert_done(rig, wanted)


def drawn_meanwhile(rig, top, act, wanted):
    """Whether what act() brings is drawn before there is an answer, and before top says that there is none."""
    rig.answers.clear()
    rig.asked.clear()
    assert rig.asked.wait(PATIENCE_S)
    act()
    screen = top.wait(wanted)
    rig.answers.set()
    top.wait_gone("no answer for")
    return "no answer for" not in screen


@pytest.mark.parametrize("act, wanted", [
    (lambda top: top.keys("?"), "faster or slower"), (lambda top: resize(top, 140, 30), r"^ drehgeber top .{110,} s$")])
def test_it_draws_at_once(rig, top, act, wanted):
    """A key and another size are not for the next answers to show; a busy machine has some tries."""
    for _ in range(5):
        if drawn_meanwhile(rig, top, lambda: act(top), wanted):
            return
        top.keys("x")
        resize(top, 100, 30)
        top.wait(r"^ drehgeber top .{60,90} s$")
        top.wait_gone("faster or slower")
    raise AssertionError("never before the next answers")
