# SPDX-License-Identifier: MIT
"""The panel of a running rig in Debian's Chromium: what it shows is what masters on the wires and the control plane are
told, what is clicked happens, and it outlives the rig. Pictures lie in the build's folder `panel` for people to see."""

import os
import re
import select
import signal
import subprocess
import sys
import time
import tty
from pathlib import Path

import pytest
from playwright.sync_api import sync_playwright

sys.path.append(str(Path(__file__).parents[1]))
from axe import serious  # noqa: E402
from script_coverage import COUNTING, counted  # noqa: E402, F401

PROGRAM = os.environ["DREHGEBER"]
PICTURES = Path(os.environ["PICTURES"])
FLAGS = ["--no-sandbox", "--disable-dev-shm-usage", *COUNTING]
WAIT_MS = 20_000
WAIT_S = 20
TRANSFERRED_MAX = 300_000
RIG = """
[rig]
name = bench
control = unix:rig.sock
[shaft main]
motion = 90DEG
[shaft pitch]
driver = main
ratio = 1:10
[encoder hf]
model = s3684-rs485
wire = pty:{folder}/hf
[encoder bi]
model = s3684-biss
wire = sim
[encoder co]
model = f3668
shaft = pitch
wire = slcan:{folder}/can
[encoder ib]
model = ocd-ib-k3
wire = modbus:127.0.0.1:0
"""


class Process:
    """A command until it says that it is ready."""

    def __init__(self, *arguments, until, folder):
        self.process = subprocess.Popen([PROGRAM, *arguments], cwd=folder, stdin=subprocess.DEVNULL,
                                        stdout=subprocess.PIPE, text=True)
        self.ready = next(line for line in self.process.stdout if re.match(until, line)).strip()

    def end(self, number=signal.SIGTERM):
        self.process.send_signal(number)
        status = self.process.wait(WAIT_S)
        self.process.stdout.close()
        return status


class Bench:
    """A rig and its page."""

    def __init__(self, folder, *options):
        self.folder = folder
        (folder / "bench.ini").write_text(RIG.format(folder=folder))
        self.control = f"unix:{folder}/rig.sock"
        self.begin()
        self.web = Process("web", self.control, "--listen", "127.0.0.1:0", *options, until="ready web", folder=folder)
        self.address = self.web.ready.split()[2]

    def begin(self):
        self.rig = Process("run", "bench.ini", until="ready rig", folder=self.folder)

    def ctl(self, *lines):
        asked = [PROGRAM, "ctl", "--control", self.control, *lines]
        return subprocess.run(asked, check=True, capture_output=True, text=True, timeout=WAIT_S).stdout.splitlines()

    def end(self):
        return self.web.end(), self.rig.end()


@pytest.fixture
def begin(tmp_path):
    """begin(OPTION...) of `drehgeber web`; it ends after its pages."""
    made = []

    def go(*options):
        made.append(Bench(tmp_path, *options))
        return made[-1]

    yield go
    assert [one.end() for one in made] == [(0, 0)] * len(made)


@pytest.fixture
def bench(begin):
    return begin()


@pytest.fixture(scope="module")
def browser():
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=FLAGS)
        yield chromium
        chromium.close()


@pytest.fixture
def visit(browser, counted):  # noqa: F811
    """visit(address, width=.., height=.., expected=PATTERN): the page, once it knows its rig. Nothing else was complained
    of, by a content security policy least of all."""
    contexts, complaints, excused = [], [], []

    def go(address, width=1280, height=800, expected=None, ready="#tabs [role=tab]", **options):
        context = browser.new_context(viewport={"width": width, "height": height}, **options)
        contexts.append(context)
        page = context.new_page()
        page.set_default_timeout(WAIT_MS)
        counted.watch(page)
        excused.append(expected)
        page.on("console", lambda said: complaints.append(said.text) if said.type in ("error", "warning") else None)
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.goto(address)
        page.wait_for_selector(ready)
        return page

    yield go
    counted.take()
    for context in contexts:
        context.close()
    assert [text for text in complaints if not any(one and re.search(one, text) for one in excused)] == []


@pytest.fixture
def page(bench, visit):
    return visit(bench.address)


def until(page, expression, argument=None):
    """Playwright's own way to wait evaluates text in the page, which its policy forbids."""
    deadline = time.monotonic() + WAIT_S
    while not page.evaluate(expression, argument):
        assert time.monotonic() < deadline, expression
        time.sleep(0.05)


def request(path, data, n):
    """A master on a serial line of the rig; at most n bytes back. A pty has no parity."""
    line = os.open(path, os.O_RDWR | os.O_NOCTTY)
    try:
        tty.setraw(line)
        os.write(line, data)
        got = b""
        while len(got) < n and select.select([line], [], [], WAIT_S)[0]:
            got += os.read(line, n - len(got))
        return got
    finally:
        os.close(line)


def words(page, panel):
    return page.locator(f"#panel-{panel} .log .words").all_inner_texts()


def shows(page, panel, text):
    until(page, "([panel, text]) => document.querySelector(`#panel-${panel}`).textContent.includes(text)",
                           [panel, text])


def tab_shows(page, name, position):
    until(page, "([name, text]) => document.querySelector(`#tab-${name} b`).textContent === text", [name, position])


def until_same(get, wanted):
    """What the page shows is at last what the command says."""
    deadline = time.monotonic() + WAIT_S
    while (got := get()) != (want := wanted()):
        assert time.monotonic() < deadline, (got, want)
        time.sleep(0.05)


def select_tab(page, name):
    page.click(f"#tab-{name}")
    page.wait_for_selector(f"#panel-{name} .faults li")


def last_words(bench, name):
    """As the command has them."""
    lines = re.findall(r'"((?:[^"]|"")*)"', bench.ctl(f"INST:SEL {name}", "TRAC:LAST? 32")[0])
    return [re.sub(r"^\S+ [<>] ", "", line.replace('""', '"')) for line in lines]


def test_42h_on_the_wire(page, bench):
    """90 degrees are 4000h of 65536 steps (chapter 5.1.2.1: 40 42, position, check sum)."""
    select_tab(page, "hf")
    assert bench.ctl("INST:SEL hf", "TRAC:LAST?") == ['""']
    assert request(bench.folder / "hf", bytes.fromhex("404202"), 7) == bytes.fromhex("40420000400042")
    until(page, "document.querySelectorAll('#panel-hf .log li').length === 2")
    assert words(page, "hf") == last_words(bench, "hf")
    tab_shows(page, "hf", "16384")


def test_sdo_on_the_wire(page, bench):
    """6004h of the geared shaft: 9 of 360 degrees in 65536 steps are 1638."""
    select_tab(page, "co")
    with open(bench.folder / "can", "r+b", buffering=0) as line:
        tty.setraw(line)
        line.write(b"S5\rO\r")
        time.sleep(0.2)
        line.write(b"t63F84004600000000000\r")
        answer = b""
        while b"t5BF8430460" not in answer:
            assert select.select([line], [], [], WAIT_S)[0]
            answer += line.read(100)
        shows(page, "co", "6004")
        until_same(lambda: words(page, "co")[-2:], lambda: last_words(bench, "co")[-2:])
    state = dict(word.split("=") for word in bench.ctl("INST:SEL co", "STAT?")[0].split(","))
    assert state["position"] == "1638"
    tab_shows(page, "co", "1638")
    assert page.inner_text("#shaft-title") == "Shaft pitch"
    until(page, "document.getElementById('angle').textContent === '9.000°'")


def test_biss_frames_as_the_command_reads_them(page, bench):
    """The simulated wire's master reads ten times a second."""
    select_tab(page, "bi")
    read = subprocess.run([PROGRAM, "biss", "s3684-biss", "read", "--shaft=90DEG"], check=True, capture_output=True,
                          text=True, timeout=WAIT_S).stdout
    multiturn, singleturn = re.search(r"MT (\d+)\s+ST (\d+)", read).groups()
    shows(page, "bi", f"position {multiturn}:{singleturn} nERR 1 nWARN 1")
    assert page.locator("#panel-bi .log .words.error").count() == 0
    bench.ctl("INST:SEL bi", "FAUL:SET singleturn_lost")
    page.wait_for_selector("#panel-bi .log .words.error:has-text('nERR 0')")
    bench.ctl("INST:SEL bi", "FAUL:CLE")
    tab_shows(page, "bi", singleturn)


def test_interbus_lamps_and_state(page, bench):
    select_tab(page, "ib")
    page.wait_for_selector("#panel-ib .lamp[aria-label='UL: on']")
    state = dict(word.split("=") for word in bench.ctl("INST:SEL ib", "STAT?")[0].split(","))
    tab_shows(page, "ib", state["position"])
    shows(page, "ib", "presets unset")


def test_sine_and_cosine_are_measured(page, bench):
    select_tab(page, "hf")
    until(page, "drehgeber.rig.shown.samples.length > 3")
    sin, cos = page.evaluate("drehgeber.rig.shown.samples.at(-1)")
    assert abs(sin**2 + cos**2 - 0.25) < 0.01


@pytest.mark.parametrize("name, fault, code", [
    ("hf", "led_current_high", "1D"),
    ("co", "temperature_high", "4200"),
    ("bi", "singleturn_lost", "nERR 0"),
    ("ib", "eeprom_silent", ""),
])
def test_a_fault_that_is_clicked_shows_its_code(page, bench, name, fault, code):
    select_tab(page, name)
    page.check(f"#{name}-{fault}")
    deadline = time.monotonic() + WAIT_S
    while bench.ctl(f"INST:SEL {name}", "FAUL:ACT?") != [f'"{fault}"']:
        assert time.monotonic() < deadline
    if code:
        until(page, "([name, code]) => document.querySelector(`#panel-${name} .latest`).textContent.includes(code)",
                               [name, code])
    page.locator(f"#panel-{name}").get_by_role("button", name="Clear all").click()
    until(page, "(id) => !document.getElementById(id).checked", f"{name}-{fault}")
    until_same(lambda: bench.ctl(f"INST:SEL {name}", "FAUL:ACT?"), lambda: ['""'])


def test_the_eeprom_is_seen(page, bench):
    """What a master stores is marked; INTERBUS has it, too."""
    select_tab(page, "bi")
    data = bench.ctl("INST:SEL bi", "NVM:DATA?")[0].strip('"')
    until(page, "drehgeber.rig.shown.memory !== null")
    page.wait_for_selector("#panel-bi .hex")
    assert "".join(page.evaluate("[...drehgeber.rig.shown.memory].map((byte) => byte.toString(16).padStart(2, '0'))")) == data.lower()
    assert page.locator("#panel-bi .hex").inner_text().startswith(f"0000  {data[:2]} {data[2:4]}")
    bench.ctl("INST:SEL bi", "BISS:REG 64,7", "BISS:REG 0,90")
    page.wait_for_selector("#panel-bi .hex mark:text-is('5A')")


def test_what_others_do_is_seen(page, bench):
    select_tab(page, "hf")
    bench.ctl("INST:SEL hf", "FAUL:SET singleturn_lost", "SHAF:VEL 30RPM")
    until(page, "document.getElementById('hf-singleturn_lost').checked")
    until(page, "document.getElementById('speed').textContent === '30.0 rpm'")
    bench.ctl("INST:SEL hf", "POW OFF")
    page.wait_for_selector("#panel-hf .lamp[aria-label='power: off']")
    until(page, "document.querySelector('#tab-hf b').textContent === 'off'")
    page.locator("#panel-hf").get_by_role("button", name="Switch on").click()
    page.wait_for_selector("#panel-hf .lamp[aria-label='power: on']")


def test_the_shaft(page, bench):
    """By its forms, by keys, by the mouse."""
    def angle():
        return float(bench.ctl("SHAF:POS?")[0])

    def comes(want):
        deadline = time.monotonic() + WAIT_S
        while abs(angle() - want) > 0.01:
            assert time.monotonic() < deadline, angle()

    page.fill("#target", "45")
    page.click("#be")
    comes(45)
    page.fill("#target", "60")
    page.fill("#rpm", "600")
    page.click("#going button[type=submit]")
    comes(60)
    until(page, "document.getElementById('angle').textContent === '60.000°'")
    page.focus("#dial")
    for key in ("PageUp", "ArrowRight", "ArrowRight", "ArrowLeft"):
        page.keyboard.press(key)
    comes(71)
    page.keyboard.press("Home")
    comes(0)
    box = page.locator("#dial").bounding_box()
    x, y, r = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2, box["width"] * 0.35
    page.mouse.move(x, y - r)
    page.mouse.down()
    page.mouse.move(x + r, y, steps=5)
    page.mouse.up()
    comes(90)
    page.fill("#rpm", "60")
    page.click("#turning button[type=submit]")
    until(page, "document.getElementById('speed').textContent === '60.0 rpm'")
    page.click("#stop")
    until(page, "document.getElementById('speed').textContent === '0.0 rpm'")


def test_the_prompt(page, bench):
    def send(line, answer):
        page.fill("#line", line)
        page.press("#line", "Enter")
        until(page, "(text) => document.getElementById('said').lastChild.textContent.startsWith(text)", answer)

    select_tab(page, "co")
    send("*IDN?", "drehgeber,")
    send("INST:SEL?", '"co"')
    send("NO:SUCH", "-113")
    send('INST:SEL "hf";:SHAF:ACC 60RPM/S;MOVE 180DEG,60RPM;*OPC?', "1")
    assert page.locator("#trouble").is_hidden()
    page.press("#line", "ArrowUp")
    assert page.input_value("#line").startswith("INST:SEL")


def test_the_rig_is_killed_and_comes_back(bench, visit):
    page = visit(bench.address)
    select_tab(page, "hf")
    assert bench.rig.end(signal.SIGKILL) == -signal.SIGKILL
    until(page, "document.getElementById('trouble').textContent.includes('the rig is gone')")
    page.wait_for_selector("#trouble:not([hidden])")
    bench.begin()
    page.wait_for_selector("#trouble", state="hidden")
    bench.ctl("SHAF:POS 12DEG")
    until(page, "document.getElementById('angle').textContent === '12.000°'")
    assert page.locator("#panel-hf").is_visible()


def test_the_panel_itself_is_gone(bench, visit):
    page = visit(bench.address, expected="WebSocket connection to .* failed")
    select_tab(page, "hf")
    assert bench.web.end() == 0
    until(page, "document.getElementById('trouble').textContent.includes('drehgeber web does not answer')")
    at = re.search(r"//([\d.:]+)/", bench.address)[1]
    again = Process("web", bench.control, "--listen", at, until="ready web", folder=bench.folder)
    page.wait_for_selector("#token")  # it has another token now
    bench.web = again


def test_who_has_no_token_is_asked_for_it(begin, visit, tmp_path):
    file = tmp_path / "token"
    file.write_text("sixteen-characters\n")
    file.chmod(0o600)
    bench = begin("--token", str(file))
    page = visit(bench.address, ready="#token")
    page.fill("#token", "seventeen-characters")
    page.press("#token", "Enter")
    until(page, "document.body.textContent.includes('not the token')")
    page.fill("#token", "sixteen-characters")
    page.press("#token", "Enter")
    page.wait_for_selector("#tabs [role=tab]")


def test_who_has_no_token_reads_where_it_is(bench, visit):
    """Behind # of the printed address; what only the playground has is not there."""
    page = visit(bench.address.split("#")[0], ready="#token")
    assert "follows #token= there" in page.inner_text("main")
    assert page.inner_text("header").split() == ["drehgeber", "A", "running", "rig."]
    assert page.locator(".card:visible").count() == 1
    assert serious(page) == []


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_serious(bench, visit, scheme):
    page = visit(bench.address, color_scheme=scheme)
    for name in ("hf", "bi", "co", "ib"):
        select_tab(page, name)
        assert serious(page) == []


def test_who_watches_can_click_nothing(begin, visit):
    bench = begin("--watch")
    page = visit(bench.address)
    select_tab(page, "hf")
    assert page.inner_text("#lead") == "A running rig, to look at."
    for name in ("#turning button", "#be", "#stop", "#target", "#hf-led_current_high"):
        assert page.locator(name).first.is_disabled(), name
    for name in ("Power cycle", "Clear all"):
        assert page.locator("#panel-hf").get_by_role("button", name=name).is_disabled()
    page.focus("#dial")
    page.keyboard.press("PageUp")
    time.sleep(0.5)
    assert bench.ctl("SHAF:POS?") == ["90.000000"]
    assert page.locator("#trouble").is_hidden()
    bench.ctl("SHAF:POS 33DEG")
    until(page, "document.getElementById('angle').textContent === '33.000°'")


def test_keys(page, bench):
    """Tabs by arrows; the search of faults, and one of them by the blank."""
    page.focus("#tab-hf")
    page.keyboard.press("ArrowRight")
    assert page.locator("#panel-bi").is_visible()
    page.wait_for_selector("#panel-bi .faults li")
    page.locator("#panel-bi").get_by_label("Search the faults").fill("housing is too hot")
    page.focus("#bi-temperature_high")
    page.keyboard.press("Space")
    deadline = time.monotonic() + WAIT_S
    while bench.ctl("INST:SEL bi", "FAUL:ACT?") != ['"temperature_high"']:
        assert time.monotonic() < deadline


def test_everything_has_a_name(page):
    nameless = """[...document.querySelectorAll('button, input, select, [role]')].filter((node) =>
        !(node.getAttribute('aria-label') || node.getAttribute('aria-labelledby') || node.labels?.length ||
          node.textContent.trim() || node.id === 'trouble')).map((node) => node.outerHTML)"""
    assert page.evaluate(nameless) == []


def test_it_is_small_and_leaves_no_token(browser, bench):
    page = browser.new_page()
    got, referers = [], []
    page.on("response", lambda response: got.append(len(response.body())))
    page.on("request", lambda asked: referers.append((asked.url, asked.headers.get("referer", ""))))
    page.goto(bench.address)
    page.wait_for_selector("#tabs [role=tab]", timeout=WAIT_MS)
    token = bench.address.split("=")[1]
    assert all(token not in url.split("#")[0] and token not in referer for url, referer in referers)
    assert page.evaluate("Object.keys(localStorage).length + Object.keys(sessionStorage).length + document.cookie.length") == 0
    page.close()
    assert len(got) > 5
    assert sum(got) < TRANSFERRED_MAX


@pytest.mark.parametrize("width, height, scheme", [(1280, 800, "light"), (360, 740, "dark")])
def test_pictures(bench, visit, width, height, scheme):
    """Nothing is wider than the screen."""
    page = visit(bench.address, width, height, color_scheme=scheme)
    bench.ctl("SHAF:VEL 60RPM")
    request(bench.folder / "hf", bytes.fromhex("404202"), 7)
    for name in ("hf", "bi", "co", "ib"):
        select_tab(page, name)
        until(page, f"drehgeber.rig.shown.key === '{name}' && drehgeber.rig.turned.rpm !== 0")
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        page.screenshot(path=PICTURES / f"screenshot-{width}-{name}.png", full_page=width < 600)
