# SPDX-License-Identifier: MIT
"""The site in Debian's Chromium. Its own search: what a newcomer types into it, and whether the page that answers is among
what he sees without scrolling; it says how long typing, finding and opening took. Pages: what axe-core finds, light and dark, and
names that stay in one piece. The switch between the pages of two versions.

usage: with DREHGEBER, the program; DREHGEBER_PAGES: `few` (axe-core looks at as few pages as have every kind of element) or
`whole`"""

import functools
import json
import os
import shutil
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from html.parser import HTMLParser
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest
from playwright.sync_api import sync_playwright

TREE = Path(__file__).resolve().parents[3]
sys.path.append(str(TREE / "tests/e2e"))
from axe import COLOURS, serious  # noqa: E402

# Root has no sandbox, and a container little of /dev/shm.
FLAGS = ["--no-sandbox", "--disable-dev-shm-usage"]
WIDTH, HEIGHT = 1280, 800
WAIT_MS = 20_000
MODELS = ("s3684-rs485", "s3684-biss", "f3668", "ocd-ib-k3")
MINUTE_S = 60
# A table on it is wider than the page.
WIDE = "src/canopen/index.html"
# The question, the page, what is on it.
QUESTIONS = [
    ("how do I make it answer 1Dh", "docs/faults.html", "FAUL:SET led_current_high"),
    ("1Dh", "docs/faults.html", "FAUL:SET led_current_high"),
    ("read the position with pyserial", "docs/wires.html", "serial.Serial("),
    ("test my master in pytest without hardware", "tools/python/index.html", "drehgeber_clock"),
    ("can bus over tcp", "docs/masters.html", "--socketcand="),
    ("simulink", "docs/cosim.html", "the importer"),
    ("look at a trace in wireshark", "docs/traces.html", "tshark"),
    ("my drive shows twice the angle", "docs/masters.html", "--set periods=1024"),
    ("flash a raspberry pi pico", "tools/rp2040/flash.html", "BOOTSEL"),
    ("two encoders on one shaft", "docs/rigs.html", "driver = motor"),
    ("install on debian", "docs/install.html", "dpkg-buildpackage"),
    ("what happens when the power is cut", "docs/design.html", "journal"),
    ("dg_host_make", "docs/c/host.h.html", "dg_host_make"),
    ("led_current_high", "docs/faults.html", "led_current_high"),
]


# Counts the questions that the worker of the search has not answered yet. The page asks it with every letter, and draws the
# list anew with every answer: when that happens while the mouse button is down, the browser opens nothing.
COUNT = """{
    const [QUERY, RESULT] = [2, 3];  // types of messages in Material for MkDocs
    window.unanswered = 0;
    window.Worker = class extends Worker {
        constructor(...given) {
            super(...given);
            this.addEventListener("message", ({data}) => { window.unanswered -= data.type === RESULT; });
        }
        postMessage(message, ...rest) {
            window.unanswered += message.type === QUERY;
            super.postMessage(message, ...rest);
        }
    };
}"""
# The whole question is answered, and the result is on the screen.
SEEN = """(link) => {
    const box = document.querySelector(link)?.getBoundingClientRect();
    return unanswered === 0 && box !== undefined && box.height > 0 && box.y < innerHeight;
}"""
# Those of these names which are broken into several lines, and how many of them are on the page.
BROKEN = """(names) => {
    const codes = [...document.querySelectorAll("td code")].filter((code) => names.includes(code.textContent));
    return [codes.filter((code) => code.getClientRects().length > 1).map((code) => code.textContent), codes.length];
}"""


class Quiet(SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("site")
    subprocess.run([TREE / "tools/site/build", os.environ["DREHGEBER"], made], check=True, timeout=180)
    return made


@contextmanager
def served(folder):
    """@return its address"""
    with ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=folder)) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


@pytest.fixture(scope="module")
def site(folder):
    with served(folder) as address:
        yield address


@pytest.fixture(scope="module")
def browser():
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=FLAGS)
        yield chromium
        chromium.close()


@contextmanager
def opened(browser, **options):
    with browser.new_page(viewport={"width": WIDTH, "height": HEIGHT}, **options) as page:
        page.set_default_timeout(WAIT_MS)
        page.add_init_script(COUNT)
        yield page


@pytest.fixture
def page(browser, site):
    with opened(browser) as page:
        page.goto(f"{site}/index.html")
        yield page


def ask(page, question, link):
    """@param link - what has to be on the screen when the search has answered"""
    page.keyboard.press("/")
    page.keyboard.type(question)
    page.wait_for_function(SEEN, arg=link)


@pytest.mark.parametrize("question, answer, told", QUESTIONS)
def test_a_newcomer_finds_it(page, question, answer, told):
    begin = time.monotonic()
    link = f'.md-search-result__item > a.md-search-result__link[href*="/{answer}"]'
    ask(page, question, link)
    page.locator(link).first.click()
    page.wait_for_url(f"**/{answer}*")
    assert told in page.locator("article").inner_text()
    took = time.monotonic() - begin
    print(f"note: '{question}': {took:.1f} s")
    assert took < MINUTE_S


def test_what_nobody_wrote_is_not_found(page):
    page.keyboard.press("/")
    page.keyboard.type("xyzzy")
    page.wait_for_function("document.querySelector('.md-search-result__meta').innerText.startsWith('No ')")


@pytest.mark.parametrize("at", ["docs/faults", "src/control/index"])
def test_names_of_faults_stay_in_one_piece(page, site, at):
    names = set()
    for model in MODELS:
        told = subprocess.run([os.environ["DREHGEBER"], "faults", model, "--json"], check=True, capture_output=True, timeout=30)
        names |= {fault["name"] for fault in json.loads(told.stdout)}
    page.goto(f"{site}/{at}.html")
    broken, found = page.evaluate(BROKEN, sorted(names))
    assert broken == []
    assert found > 5


class Kinds(HTMLParser):
    """The kinds of elements on a page: what a style can tell apart."""

    def __init__(self, path):
        super().__init__()
        self.found = set()
        self.feed(path.read_text())

    def handle_starttag(self, tag, attrs):
        self.found.add((tag, dict(attrs).get("class")))


def choose_few(kinds) -> list:
    """Of pages, given as {name: kinds}, as few as have every kind of element among them."""
    left, chosen = set().union(*kinds.values()), []
    while left:
        chosen.append(max(kinds, key=lambda name: len(kinds[name] & left)))
        left -= kinds[chosen[-1]]
    return chosen


@pytest.fixture(scope="module")
def pages(folder):
    """The playground has its own test."""
    paths = sorted(path for path in folder.rglob("*.html") if path.parent.name != "playground")
    kinds = {str(path.relative_to(folder)): Kinds(path).found for path in paths}
    assert len(kinds) > 100
    return list(kinds) if os.environ["DREHGEBER_PAGES"] == "whole" else [*choose_few(kinds), WIDE]


@pytest.mark.parametrize("scheme, kept, options", [("light", "default", None), ("dark", "slate", COLOURS)])
def test_axe_finds_nothing_serious(browser, site, pages, scheme, kept, options):
    found = []
    with opened(browser, color_scheme=scheme) as page:
        for name in pages:
            page.goto(f"{site}/{name}")
            page.wait_for_selector(f"body[data-md-color-scheme={kept}]")
            found += [f"{name}: {text}" for text in serious(page, options)]
        page.goto(f"{site}/index.html")
        ask(page, QUESTIONS[0][0], ".md-search-result__link")
        found += [f"results of the search: {text}" for text in serious(page, options)]
    assert found == []


def test_the_switch_leads_to_the_other_version_and_back(browser, folder, tmp_path):
    for version in ("0.3.0", "1.0.0"):
        shutil.copytree(folder, tmp_path / version)
    subprocess.run([TREE / "tools/site/versions", tmp_path], check=True, timeout=MINUTE_S)
    with served(tmp_path) as address, opened(browser) as page:
        page.goto(f"{address}/1.0.0/docs/rigs.html")
        for version in ("0.3.0", "1.0.0"):
            page.hover(".md-version")
            assert page.locator(".md-version__link").all_text_contents() == ["1.0.0", "0.3.0"]
            page.click(f".md-version__link:text-is('{version}')")
            page.wait_for_url(f"{address}/{version}/**")
            assert page.inner_text(".md-version__current") == version
