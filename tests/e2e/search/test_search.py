# SPDX-License-Identifier: MIT
"""The site's own search in Debian's Chromium: what a newcomer types into it, and whether the page that answers is among
what he sees without scrolling. Says how long typing, finding and opening took."""

import functools
import os
import subprocess
import threading
import time
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest
from playwright.sync_api import sync_playwright

TREE = Path(__file__).resolve().parents[3]
# Root has no sandbox, and a container little of /dev/shm.
FLAGS = ["--no-sandbox", "--disable-dev-shm-usage"]
WIDTH, HEIGHT = 1280, 800
WAIT_MS = 20_000
MINUTE_S = 60
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


class Quiet(SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("site")
    subprocess.run([TREE / "tools/site/build", os.environ["DREHGEBER"], folder], check=True, timeout=180)
    with ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=folder)) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


@pytest.fixture(scope="module")
def browser():
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=FLAGS)
        yield chromium
        chromium.close()


@pytest.fixture
def page(browser, site):
    page = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT})
    page.set_default_timeout(WAIT_MS)
    page.goto(f"{site}/index.html")
    yield page
    page.close()


@pytest.mark.parametrize("question, answer, told", QUESTIONS)
def test_a_newcomer_finds_it(page, question, answer, told):
    begin = time.monotonic()
    page.keyboard.press("/")
    page.keyboard.type(question)
    link = page.locator(f'.md-search-result__item > a.md-search-result__link[href*="/{answer}"]').first
    link.wait_for()
    assert link.bounding_box()["y"] < HEIGHT, page.locator(".md-search-result__item h1").all_inner_texts()
    link.click()
    page.wait_for_url(f"**/{answer}*")
    assert told in page.locator("article").inner_text()
    took = time.monotonic() - begin
    print(f"note: '{question}': {took:.1f} s")
    assert took < MINUTE_S


def test_what_nobody_wrote_is_not_found(page):
    page.keyboard.press("/")
    page.keyboard.type("xyzzy")
    page.wait_for_function("document.querySelector('.md-search-result__meta').innerText.startsWith('No ')")
