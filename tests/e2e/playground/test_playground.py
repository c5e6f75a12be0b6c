# SPDX-License-Identifier: MIT
"""The playground in Debian's Chromium, without a screen: the bytes of the Python package and of the command, faults,
what outlives a reload, and how it looks: screenshots lie beside the page for people to see."""

import functools
import os
import subprocess
import sys
import threading
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest
from playwright.sync_api import sync_playwright

sys.path.append(str(Path(__file__).parents[1]))
from axe import serious  # noqa: E402
from script_coverage import COUNTING, counted  # noqa: E402, F401

FOLDER = Path(os.environ["PLAYGROUND"])
PROGRAM = os.environ["DREHGEBER"]
HANDLE = [os.environ["HANDLE_PYTHON"], str(Path(__file__).with_name("handle.py"))]
# Root has no sandbox, and a container little of /dev/shm.
FLAGS = ["--no-sandbox", "--disable-dev-shm-usage", *COUNTING]
TRANSFERRED_MAX = 300_000
WAIT_MS = 20_000
PANELS = ("hiperface", "biss", "canopen", "interbus")
# 1.25 s from the shaft's start on; the page's frame is latched half a clock after it was asked for.
MOMENT_NS = 1_250_000_000
HALF_CLOCK_NS = 500


class Quiet(SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


@pytest.fixture(scope="module")
def server():
    with ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=FOLDER)) as httpd:
        threading.Thread(target=httpd.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{httpd.server_port}"
        httpd.shutdown()


@pytest.fixture(scope="module")
def browser():
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=FLAGS)
        yield chromium
        chromium.close()


@pytest.fixture
def visit(browser, counted):  # noqa: F811
    """Open an address with an empty storage: visit(address, width=.., height=..). Nothing was complained of."""
    contexts, complaints = [], []

    def go(address, width=1280, height=800, **options):
        context = browser.new_context(viewport={"width": width, "height": height}, **options)
        contexts.append(context)
        page = context.new_page()
        page.set_default_timeout(WAIT_MS)
        counted.watch(page)
        page.on("console", lambda said: complaints.append(said.text) if said.type in ("error", "warning") else None)
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.goto(address)
        page.wait_for_function("globalThis.drehgeber")
        return page

    yield go
    counted.take()
    for context in contexts:
        context.close()
    assert complaints == []


@pytest.fixture
def still(visit, server):
    """The page with a clock that stands."""
    return visit(f"{server}/index.html#still")


@pytest.fixture
def reload(still, counted):  # noqa: F811
    """reload(): that page, loaded again."""
    def go():
        counted.take()
        still.reload()
        still.wait_for_function("globalThis.drehgeber")

    return go


def let_pass(page, ns):
    page.evaluate(f"drehgeber.pass({ns}n)")


def press(page, panel, name):
    page.locator(f"#panel-{panel}").get_by_role("button", name=name, exact=True).click()


def bytes_of_last(page, panel):
    return page.locator(f"#panel-{panel} .log .bytes").last.inner_text().replace(" ", "").lower()


def by_handle(model):
    """The Python package's answer."""
    return subprocess.run([*HANDLE, model], check=True, capture_output=True, text=True, timeout=30).stdout.strip()


def turn(page, panel, ns=MOMENT_NS):
    page.click(f"#tab-{panel}")
    page.fill("#rpm", "60")
    page.click("#turning button[type=submit]")
    let_pass(page, ns)


def test_42h_as_the_handle(still):
    turn(still, "hiperface")
    press(still, "hiperface", "42h position")
    let_pass(still, 100_000_000)
    assert bytes_of_last(still, "hiperface") == by_handle("s3684-rs485")


def test_sdo_as_the_handle(still):
    turn(still, "canopen")
    press(still, "canopen", "SDO 6004h position")
    assert bytes_of_last(still, "canopen") == by_handle("f3668")


def test_words_as_the_handle(still):
    turn(still, "interbus")
    press(still, "interbus", "Data cycle")
    assert bytes_of_last(still, "interbus") == by_handle("ocd-ib-k3")


def test_biss_bits_as_the_handle(still):
    turn(still, "biss", MOMENT_NS - HALF_CLOCK_NS)
    press(still, "biss", "Frame")
    bits = still.evaluate("drehgeber.rig.encoder('biss').master.last.bits.join('')")
    want = by_handle("s3684-biss")
    assert int(bits, 2) == int(want, 16)


def test_biss_words_as_the_command(still):
    still.click("#tab-biss")
    still.fill("#target", "90")
    still.click("#be")
    press(still, "biss", "Frame")
    press(still, "biss", "78h device ID")
    said = still.locator("#panel-biss .log .words").all_inner_texts()
    command = [PROGRAM, "biss", "s3684-biss"]
    read = subprocess.run([*command, "read", "--shaft=90DEG"], check=True, capture_output=True, text=True, timeout=30)
    assert said[0].split() == read.stdout.split()
    registers = subprocess.run([*command, "registers", "0x78", "8"], check=True, capture_output=True, text=True, timeout=30)
    assert said[1] == f"register 78h = {registers.stdout.strip()}"


def test_biss_control_bits_are_shown(still):
    """S, CTS, ID 0, ADR 69h, its CRC, R, W and S: BiSS C protocol description, control frame."""
    still.click("#tab-biss")
    press(still, "biss", "69h errors")
    control = still.evaluate("drehgeber.rig.encoder('biss').master.control.slice(0, 12).map((bit) => bit.cdm).join('')")
    assert control == "1" "1" "000" "1101001"
    assert still.locator("#panel-biss .control li").count() > 30


@pytest.mark.parametrize(
    "panel, fault, code",
    [
        ("hiperface", "led_current_high", "50 1D"),
        ("canopen", "temperature_high", "00 42"),
        ("biss", "led_current_high", "register 69h = 01"),
        ("interbus", "singleturn_lost", "80 00"),
    ],
)
def test_a_fault_shows_its_code(still, panel, fault, code):
    still.click(f"#tab-{panel}")
    assert still.locator(f"#panel-{panel} .log .words.error").count() == 0
    still.check(f"#{panel}-{fault}")
    let_pass(still, 3_000_000_000)
    assert still.locator(f"#panel-{panel} .log .words.error").count() > 0
    assert code in still.locator(f"#panel-{panel} .log").inner_text()
    assert still.locator(f"#panel-{panel} .latest").inner_text().startswith("Told last: ")


def test_a_flipped_bit_is_found_at_the_next_start(still):
    """EMCY 5100h, the manual's chapter 15."""
    still.click("#tab-canopen")
    still.check("#canopen-eeprom_tpdo1")
    let_pass(still, 2_000_000_000)
    assert "5100h" not in still.locator("#panel-canopen .log").inner_text()
    press(still, "canopen", "Power cycle")
    let_pass(still, 2_000_000_000)
    assert "5100h" in still.locator("#panel-canopen .log").inner_text()


def test_every_fault_can_be_clicked(still):
    for panel in PANELS:
        assert still.locator(f"#panel-{panel} .faults input").count() > 10
    assert still.locator(".faults input:disabled").count() == 0


def data_cycles(still, count):
    """So many of them. @return how many brought nothing"""
    nothing = still.locator("#panel-interbus .log .words", has_text="no data in this cycle")
    before = nothing.count()
    for _ in range(count):
        press(still, "interbus", "Data cycle")
    return nothing.count() - before


def test_a_transmission_error_costs_six_cycles(still):
    """Its own, and the five behind it: no. 5 of src/interbus/README.md."""
    still.click("#tab-interbus")
    assert data_cycles(still, 1) == 0
    still.check("#interbus-wire_damage")
    assert data_cycles(still, 1) == 1
    assert "transmission error" in still.locator("#panel-interbus .log").inner_text()
    still.uncheck("#interbus-wire_damage")
    assert data_cycles(still, 5) == 5
    assert data_cycles(still, 1) == 0


def test_a_ring_that_was_cut_is_identified_anew(still):
    still.click("#tab-interbus")
    assert data_cycles(still, 1) == 0
    still.check("#interbus-wire_break")
    assert data_cycles(still, 2) == 2
    still.uncheck("#interbus-wire_break")
    assert data_cycles(still, 1) == 0
    notes = still.locator("#panel-interbus .log .note", has_text="ID cycle").all_inner_texts()
    assert [note.split(",")[0] for note in notes] == [f"ID cycle: {reached} of 1 devices" for reached in (1, 0, 1)]


def test_a_broken_wire_reads_high(still):
    """BiSS: all bits are 1, and no check sum is."""
    still.click("#tab-biss")
    still.check("#biss-wire_break")
    press(still, "biss", "Frame")
    words = still.locator("#panel-biss .log .words.error").last.inner_text()
    assert words.startswith("MT 4095") and words.endswith("CRC wrong")


def test_eeprom_outlives_a_reload(still, reload):
    """Bank 7 is the first of the user's: 40h selects it, and not for good."""
    still.click("#tab-biss")
    for register, data in (("40", "07"), ("00", "A5 5A")):
        form = still.locator("#panel-biss form").nth(1)
        form.get_by_label("Register").fill(register)
        form.get_by_label("Bytes").fill(data)
        form.get_by_role("button", name="Write").click()
    let_pass(still, 1_000_000_000)
    still.wait_for_selector("#panel-biss .hex mark")
    reload()
    master = "drehgeber.rig.encoder('biss').master"
    assert still.evaluate(f"{master}.writeRegisters(0x40, [7])") == [7]
    assert still.evaluate(f"{master}.readRegisters(0, 2)") == [0xA5, 0x5A]
    still.click("#tab-biss")
    press(still, "biss", "As delivered")
    assert still.evaluate(f"drehgeber.pass(1000000000n), {master}.writeRegisters(0x40, [7])") == [7]
    assert still.evaluate(f"{master}.readRegisters(0, 2)") == [0xFF, 0xFF]


def test_a_broken_image_does_not_stop_the_page(still, reload):
    still.evaluate("Object.keys(localStorage).forEach((key) => localStorage.setItem(key, btoa('nonsense')))")
    reload()
    assert "as delivered" in still.locator("#panel-hiperface .log").inner_text()
    turn(still, "hiperface", 0)
    press(still, "hiperface", "42h position")
    let_pass(still, 100_000_000)
    assert bytes_of_last(still, "hiperface").startswith("4042")


# What a button sends and what comes back, or how the page words it: the examples of the manuals, as tests/conformance has
# them. Of forms the fields stand before it.
ASKED = {
    "hiperface": [
        ((), "50h status", ["40 50 10", "40 50 00 10"]),
        ((), "44h temperature", ["40 44 48 4C", "40 44 48 00 25 69"]),
        ((), "52h type label", ["40 52 12", "40 52 E4 27 70 00 A1"]),
        ((), "56h serial number", ["40 56 16", "40 56 31 32 33 34 35 36 37 38 39 76 31 2E 30 2E 38" + " 00" * 14 + " 31 32 30 37 32 30 31 39 66"]),
        ((), "53h reset", ["40 53 13"]),
        (("40 50 10",), "Send", ["40 50 10", "40 50 00 10"]),
    ],
    "biss": [
        ((), "6Bh warnings", ["register 6Bh = 01"]),
        (("44h", "4"), "Read", ["register 44h = 07 5B CD 15"]),
        (("40", "07"), "Write", ["register 40h = 07"]),
    ],
    "canopen": [
        ((), "NMT start", ["01 00", "00 00 00 00", "00 00", "00 00 00 00 C0 84"]),
        ((), "SYNC", ["SYNC", "00 00 00 00"]),
        ((), "NMT pre-op", ["80 00"]),
        ((), "NMT reset", ["81 00", "00"]),
        (("1018h", "1"), "Read", ["40 18 10 01 00 00 00 00", "43 18 10 01 13 00 00 00"]),
        (("63F", "40 18 10 01 00 00 00 00"), "Send", ["40 18 10 01 00 00 00 00", "43 18 10 01 13 00 00 00"]),
    ],
    "interbus": [
        ((), "ID cycle", ["ID 0237"]),
        (("00000000",), "Cycle with it", ["00 00 00 00"]),
    ],
}


def fill_in(page, panel, values, name):
    """The form with that button."""
    form = page.locator(f"#panel-{panel} form").filter(has=page.get_by_role("button", name=name, exact=True))
    for i, value in enumerate(values):
        form.locator("input").nth(i).fill(value)
    form.get_by_role("button", name=name, exact=True).click()


def test_what_masters_can_ask(still):
    for panel, rows in ASKED.items():
        still.click(f"#tab-{panel}")
        for values, name, want in rows:
            still.locator(f"#panel-{panel}").get_by_role("button", name="Clear", exact=True).click()
            if values:
                fill_in(still, panel, values, name)
            else:
                press(still, panel, name)
            let_pass(still, 500_000_000)
            lines = still.locator(f"#panel-{panel} .log li").all()
            told = [(line.locator(".bytes").all_inner_texts() or line.locator(".words").all_inner_texts())[0] for line in lines]
            assert told == want, name
            assert still.locator("#trouble").is_hidden()


RIGHT = {(panel, name): values for panel, rows in ASKED.items() for values, name, _ in rows}
WRONG = [
    ("hiperface", "Send", ("4O 42",), '"4O 42" is no row of bytes'),
    ("biss", "Read", ("4G", "1"), 'register "4G" is no hexadecimal number'),
    ("biss", "Write", ("40", "7"), '"7" is no row of bytes'),
    ("canopen", "Read", ("1018", "one"), 'sub-index "one" is no hexadecimal number'),
    ("canopen", "Send", ("NMT", ""), 'identifier "NMT" is no hexadecimal number'),
    ("interbus", "Cycle with it", ("-",), 'OUT "-" is no hexadecimal number'),
]


def test_a_form_says_what_is_wrong(still):
    """Until something is right; without power nothing is sent either."""
    for panel, name, values, why in WRONG:
        still.click(f"#tab-{panel}")
        fill_in(still, panel, values, name)
        assert still.inner_text("#trouble").startswith(why)
        fill_in(still, panel, RIGHT[panel, name], name)
        assert still.locator("#trouble").is_hidden()
    press(still, panel, "Switch off")
    fill_in(still, panel, RIGHT[panel, name], name)
    assert still.inner_text("#trouble") == "INTERBUS: no power"


def test_time_stands_steps_and_runs(still):
    assert still.inner_text("#time") == "1.000 s"
    still.click("#step")
    still.wait_for_function("document.getElementById('time').textContent === '1.010 s'")
    still.select_option("#pace", "0.1")
    still.click("#run")
    assert still.inner_text("#run") == "Running"
    still.wait_for_function("Number.parseFloat(document.getElementById('time').textContent) > 1.05")
    still.click("#run")
    stood = still.evaluate("String(drehgeber.rig.now)")
    still.evaluate("new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)))")
    assert (still.inner_text("#run"), still.evaluate("String(drehgeber.rig.now)")) == ("Standing", stood)


def test_scpi(still):
    def send(line):
        still.fill("#line", line)
        still.press("#line", "Enter")
        return still.locator("#said div").last.inner_text()

    assert send("*IDN?").startswith("drehgeber,s3684-rs485")
    send("SHAF:POS 90DEG")
    assert send("SHAF:POS?") == "90.000000"
    assert send("NO:SUCH").startswith("-113")
    still.press("#line", "ArrowUp")
    assert still.input_value("#line") == "NO:SUCH"


def test_scpi_that_waits(still):
    """A turn of 60 rpm takes a second; nothing else is done in the meantime."""
    for line in ("SHAF:MOVE 1REV,60RPM;*OPC?", "SHAF:POS?"):
        still.fill("#line", line)
        still.press("#line", "Enter")
    assert still.inner_text("#trouble") == "The line before is not done yet"
    let_pass(still, 2_000_000_000)
    still.wait_for_function("document.querySelector('#said').lastElementChild.textContent === '1'")


def test_keys(still):
    """Tabs by arrows, the shaft by arrows."""
    still.focus("#tab-hiperface")
    still.keyboard.press("ArrowRight")
    assert still.locator("#panel-biss").is_visible()
    still.focus("#dial")
    for key in ("PageUp", "ArrowRight", "ArrowRight", "ArrowLeft"):
        still.keyboard.press(key)
    still.wait_for_function("document.getElementById('dial').getAttribute('aria-valuenow') === '11.0'")


def test_the_mouse_turns_it(still):
    box = still.locator("#dial").bounding_box()
    x, y, r = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2, box["width"] * 0.35
    still.mouse.move(x, y - r)
    still.mouse.down()
    still.mouse.move(x + r, y)
    still.mouse.up()
    still.wait_for_function("Math.abs(document.getElementById('dial').getAttribute('aria-valuenow') - 90) < 1")


def test_everything_has_a_name(still):
    nameless = """[...document.querySelectorAll('button, input, select, [role]')].filter((node) =>
        !(node.getAttribute('aria-label') || node.getAttribute('aria-labelledby') || node.labels?.length ||
          node.textContent.trim() || node.id === 'trouble')).map((node) => node.outerHTML)"""
    assert still.evaluate(nameless) == []


def test_it_is_small(browser, server):
    page = browser.new_page()
    got = []
    page.on("response", lambda response: got.append(len(response.body())))
    page.goto(f"{server}/index.html")
    page.wait_for_function("globalThis.drehgeber", timeout=WAIT_MS)
    page.close()
    assert len(got) > 5
    assert sum(got) < TRANSFERRED_MAX
    assert (FOLDER / "drehgeber.html").stat().st_size < TRANSFERRED_MAX


def test_it_turns_at_first_sight(visit, server):
    page = visit(f"{server}/index.html")
    assert page.evaluate("drehgeber.rig.speed") == 10
    page.wait_for_function("document.getElementById('angle').textContent !== '0.000°'")
    for panel in PANELS:
        page.click(f"#tab-{panel}")
        assert len(page.inner_text(f"#panel-{panel} .what").split()) > 10
        cards = page.locator(f"#panel-{panel} .card")
        assert page.locator(f"#panel-{panel} .card > .hint").count() == cards.count() > 3


def test_it_stands_for_those_who_want_less_motion(visit, server):
    page = visit(f"{server}/index.html", reduced_motion="reduce")
    assert page.evaluate("drehgeber.rig.speed") == 0


LA26 = "[model la26]\nbase = s3674-biss\nst = 26\nlc = 0\n"
WORD40 = """[model wide]
base = ssi-25
[model word40]
base = wide
mt = 16
st = 20
code = binary
error_bit = high
parity = even
frame = 0 P E Y 1
"""
ACME = """[DeviceInfo]
ProductName=Acme
[DeviceComissioning]
NodeID=0x21
[1000]
DataType=7
DefaultValue=0x00010196
[6004]
DataType=7
[6501]
DataType=7
DefaultValue=3600
"""
BENCH = """[shaft spindle]
motion = 60RPM
[bus line]
wire = pty
[encoder left]
model = s3684-rs485
bus = line
[encoder right]
model = s3684-rs485
bus = line
address = 0x41
"""


def put_in(page, text):
    """The text of an encoder; what is wrong with it."""
    if not page.locator("#own").is_visible():
        page.click("details.own summary")
    page.fill("#own-text", text)
    page.click("#own button[type=submit]")
    return page.inner_text("#own-wrong") if page.locator("#own-wrong").is_visible() else None


@pytest.mark.parametrize("text, name, said, bits", [
    (LA26, "la26", "position 16777216", 34), (WORD40, "word40", "position 262144", 40)])
def test_a_text_is_an_encoder(still, text, name, said, bits):
    """At a quarter turn, and a while later than the others were switched on."""
    let_pass(still, 3_000_000_000)
    still.fill("#target", "90")
    still.click("#be")
    assert put_in(still, text) is None
    assert still.inner_text("#tab-own small") == name
    assert still.get_attribute("#tab-own", "aria-selected") == "true"
    press(still, "own", "Frame")
    assert still.locator("#panel-own .log .words").last.inner_text() == said
    still.wait_for_function("(n) => document.querySelectorAll('#panel-own .bits li').length === n", arg=bits)
    still.locator("#panel-own").get_by_label("Search the faults").wait_for()


def test_an_eds_file_is_an_encoder(still):
    """It takes the place of the text that was there before, and answers as its file says."""
    assert put_in(still, LA26) is None
    assert put_in(still, ACME) is None
    assert still.locator("#tabs [role=tab]").count() == len(PANELS) + 1
    still.fill("#target", "90")
    still.click("#be")
    let_pass(still, 10_000_000)
    still.wait_for_function("document.querySelector('#tab-own b').textContent === '900'")
    still.locator("#panel-own").get_by_label("Index").fill("6501")
    still.locator("#panel-own").get_by_label("Sub").fill("0")
    press(still, "own", "Read")
    assert bytes_of_last(still, "own") == "43016500100e0000"
    still.focus("#tab-own")
    still.keyboard.press("ArrowRight")
    assert still.get_attribute("#tab-hiperface", "aria-selected") == "true"


def test_a_rig_file_runs(still):
    """Both encoders of the line hear the request, and the dial is their shaft: 60 rpm, on for a second already."""
    assert put_in(still, BENCH) is None
    assert still.locator("#tabs [role=tab]").count() == len(PANELS) + 2
    assert still.inner_text("#tab-own-2").startswith("right")
    still.click("#tab-own-2")
    let_pass(still, 250_000_000)
    still.wait_for_function("document.getElementById('angle').textContent === '450.000°'")
    press(still, "own-2", "42h position")
    let_pass(still, 100_000_000)
    for panel in ("own", "own-2"):
        assert [line.inner_text()[:5] for line in still.locator(f"#panel-{panel} .log .bytes").all()] == ["41 42", "41 42"]
    still.click("#tab-hiperface")
    still.wait_for_function("document.getElementById('angle').textContent === '0.000°'")
    assert put_in(still, BENCH.replace("0x41", "0x40")).startswith("line 11: address: 0x40 is address of [encoder left] already")
    assert put_in(still, LA26) is None
    assert still.locator("#tabs [role=tab]").count() == len(PANELS) + 1


@pytest.mark.parametrize("text, wrong", [
    (LA26.replace("26\n", "99\n"), "line 3: st 99: expected a number in 8..32"),
    (LA26.replace("s3674-biss", "nobody"), "line 2: base: nobody is unknown; expected one of:"),
    ("st = 26\n", "no object"), ("", "no object"), ("[1000]\nDataType=0x20\n", "no object that can be read")])
def test_what_is_wrong_in_a_text_is_told(still, text, wrong):
    """And the encoder of the text before stays."""
    assert put_in(still, LA26) is None
    assert put_in(still, text).startswith(wrong)
    assert still.inner_text("#tab-own small") == "la26"
    assert put_in(still, LA26) is None


def test_three_things_to_try(still):
    """60 rpm each way; error 1Dh of a worn LED; no power, and the position again without a turn."""
    still.click("#try-turn")
    assert still.evaluate("drehgeber.rig.speed") == 60
    still.click("#try-turn")
    assert still.evaluate("drehgeber.rig.speed") == -60
    still.click("#tab-interbus")
    still.click("#try-led")
    assert still.get_attribute("#try-led", "aria-pressed") == "true"
    let_pass(still, 3_000_000_000)
    assert "1D" in still.inner_text("#panel-hiperface .latest")
    still.click("#stop")
    before = still.inner_text("#tab-hiperface b")
    still.click("#try-power")
    still.wait_for_function("document.querySelector('#tab-hiperface b').textContent === 'off'")
    assert still.get_attribute("#try-power", "aria-pressed") == "true"
    still.click("#try-power")
    let_pass(still, 1_000_000_000)
    still.wait_for_function("(before) => document.querySelector('#tab-hiperface b').textContent === before", arg=before)


def selected(page):
    return page.locator("[role=tab][aria-selected=true]").get_attribute("id").removeprefix("tab-")


def test_a_link_has_a_state(visit, server):
    """Encoder, shaft, fault and power of an address; a quarter turn is 16384 of 65536 steps."""
    page = visit(f"{server}/index.html#model=f3668&shaft=90DEG&fault=temperature_high,led_current_high&still")
    page.wait_for_function("document.getElementById('angle').textContent === '90.000°'")
    assert selected(page) == "canopen"
    assert page.inner_text("#tab-canopen b") == "16384"
    active = "drehgeber.shown.encoder.faults().filter(({ active }) => active).map(({ name }) => name).sort()"
    assert page.evaluate(active) == ["led_current_high", "temperature_high"]
    page.evaluate("location.hash = '#model=s3684-biss&shaft=-30.5RPM&power=off'")
    page.wait_for_function("drehgeber.rig.speed === -30.5")
    page.wait_for_function("document.querySelector('#tab-biss b').textContent === 'off'")
    assert selected(page) == "biss"
    assert page.evaluate("drehgeber.panels.flatMap(({ encoder }) => encoder.faults()).some(({ active }) => active)") is False


@pytest.mark.parametrize("state", ["model=f3668&shaft=90DEG&fault=led_current_high&still", "model=s3684-biss&shaft=-12.5RPM&power=off&still",
                                   "model=s3684-rs485&shaft=0DEG&still"])
def test_the_page_writes_its_link(visit, server, state):
    page = visit(f"{server}/index.html#{state}")
    page.evaluate("history.replaceState(null, '', '#')")
    page.click("#link")
    page.wait_for_function("document.getElementById('tried').textContent.includes('address bar')")
    assert page.evaluate("location.hash") == f"#{state}"


@pytest.mark.parametrize("state, why", [
    ("model=f36", "model=f36: expected s3684-rs485, s3684-biss, f3668, ocd-ib-k3"),
    ("shaft=90", "shaft=90: expected 90DEG, 2.5REV or 60RPM"),
    ("model=f3668&fault=flood", "fault=flood: f3668 has no such fault; the list of faults has the names"),
    ("power=maybe", "power=maybe: expected on or off"),
    ("moddel=f3668", "moddel: expected model, shaft, fault, power, still"),
])
def test_a_link_that_is_wrong_is_refused(visit, server, state, why):
    page = visit(f"{server}/index.html#{state}")
    assert page.inner_text("#trouble") == why
    assert selected(page) == "hiperface"


def test_it_is_small_in_another_page(visit, server):
    """The front page of the site has it: steps, dial, positions and the wire."""
    page = visit(f"{server}/index.html#still")
    assert page.locator("header").is_visible()
    page.evaluate("document.body.append(Object.assign(document.createElement('iframe'), { src: 'index.html', width: 900, height: 700 }))")
    inner = page.frame_locator("iframe")
    inner.locator("#tab-biss").click()
    for shown in ("#try-led", "#dial", "#panel-biss .log"):
        assert inner.locator(shown).is_visible()
    for hidden in ("header", "#prompt", "#turning", "#panel-biss .faults"):
        assert inner.locator(hidden).is_hidden()


def test_values_have_words_and_units(still):
    """Chapter 5.1.1: the signals stand around 2.5 V; at 0 degrees the cosine is at its crest of 0.25 V."""
    facts = """Object.fromEntries([...document.querySelectorAll('#panel-hiperface dl div')].map(
        (row) => [...row.children].map((one) => one.textContent)))"""
    got = still.evaluate(facts)
    assert (got["sine +"], got["cosine +"], got["cosine −"]) == ("2.500 V", "2.750 V", "2.250 V")
    assert got["baud rate"] == "9600 Bd"
    assert list(got)[:3] == ["mode", "errors", "position"]  # where its wire is, only a running rig can say


def test_one_position_at_one_moment(visit, server):
    page = visit(f"{server}/index.html")
    page.click("#try-turn")
    both = """new Promise((resolve) => {
        const seen = [];
        const look = () => {
            seen.push([document.querySelector('#tab-hiperface b').textContent,
                       [...document.querySelectorAll('#panel-hiperface dt')].find((one) => one.textContent === 'position').nextSibling.textContent]);
            seen.length < 30 ? requestAnimationFrame(look) : resolve(seen);
        };
        look();
    })"""
    seen = page.evaluate(both)
    assert all(tab == device for tab, device in seen)
    assert len({tab for tab, _ in seen}) > 3


def test_the_last_command_is_on_one_line(still):
    still.click("#tab-interbus")
    still.wait_for_function("document.querySelector('#panel-interbus dl').textContent.includes('last command')")
    fact = """(() => {
        const told = [...document.querySelectorAll('#panel-interbus dt')].find((one) => one.textContent === 'last command').nextSibling;
        const all = document.createRange();
        all.selectNodeContents(told);
        return [told.textContent, all.getClientRects().length];
    })()"""
    assert still.evaluate(fact) == ["00000000h", 1]


def test_names_in_the_figure_are_not_cut_off(still):
    """All names that are written, and where they end."""
    still.click("#tab-biss")
    still.evaluate("""() => {
        globalThis.written = [];
        const write = CanvasRenderingContext2D.prototype.fillText;
        CanvasRenderingContext2D.prototype.fillText = function (text, x, y) {
            written.push([text, x + this.measureText(text).width <= this.canvas.clientWidth]);
            write.call(this, text, x, y);
        };
    }""")
    press(still, "biss", "Frame")
    still.wait_for_function("written.some(([text]) => text === 'idle')")
    assert [text for text, whole in still.evaluate("written") if not whole] == []


def test_a_window_of_one_pixel(still):
    still.set_viewport_size({"width": 1, "height": 1})
    still.evaluate("""() => {
        document.querySelector('#panel-hiperface canvas').style.cssText = 'width: 1px; height: 1px';
        drehgeber.draw();
    }""")
    assert still.locator("#trouble").is_hidden()


def test_the_pages_are_linked(visit, server):
    """In the site and from a file they are there; a server of this folder alone has none."""
    page = visit((FOLDER / "drehgeber.html").as_uri())
    page.click("#pages")
    page.wait_for_url("**/README.md")
    assert "drehgeber" in page.inner_text("body")
    assert visit(f"{server}/index.html").locator("#pages").is_hidden()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_serious(visit, server, scheme):
    page = visit(f"{server}/index.html#still", color_scheme=scheme)
    for panel in PANELS:
        page.click(f"#tab-{panel}")
        page.evaluate("drehgeber.panels.forEach((panel) => panel.master.ask(panel.encoder)), drehgeber.pass(100000000n)")
        assert serious(page) == []


@pytest.mark.parametrize("width, height, scheme", [(1280, 800, "light"), (360, 740, "dark")])
def test_one_file_without_a_server(visit, width, height, scheme):
    """It runs by itself, nothing is wider than the screen, and pictures are kept."""
    page = visit((FOLDER / "drehgeber.html").as_uri(), width, height, color_scheme=scheme)
    page.click("#turning button[type=submit]")
    for panel in PANELS:
        page.click(f"#tab-{panel}")
        page.wait_for_function(f"document.querySelectorAll('#panel-{panel} .log li').length > 2")
        if panel == "biss":
            press(page, "biss", "69h errors")
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        page.screenshot(path=FOLDER / f"screenshot-{width}-{panel}.png", full_page=width < 600)
    first = page.evaluate("drehgeber.rig.speed")
    assert first == 60
