# SPDX-License-Identifier: MIT
"""The site as it is built for readers: no warning, no dead link, nothing from elsewhere, what pages say, search."""
import html
import json
import os
import posixpath
import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest
from lunr import lunr
from markdown_it import MarkdownIt

TREE = Path(__file__).resolve().parents[2]
sys.path.append(str(TREE / "tests/gates"))
from sources import files  # noqa: E402

LEFT_OUT = (".github/", ".gitlab/")
PAGES = [page for page in files(str(TREE), suffixes=(".md",)) if not page.startswith(LEFT_OUT)]
# What a newcomer types, and the page and part that answers, among the first three that are found.
QUESTIONS = {
    "how do I make it answer 1Dh": "docs/faults.html#how-do-i-make-it-answer-1dh",
    "1Dh": "docs/faults.html",
    "led_current_high": "docs/faults.html",
    "wireshark": "docs/traces.html#canopen-wireshark",
    "power cut": "docs/proof.html#power-cuts",
    "dg_host_make": "docs/c/host.h.html#dg_host_make",
    "USF drift": "docs/design.html#universal-scaling-without-drift",
}


class Page(HTMLParser):
    """Where a page leads, its anchors, what it loads, and how much of what is on it."""

    def __init__(self, text: str):
        super().__init__()
        self.links, self.anchors, self.loaded, self.tags = [], set(), [], []
        self.inside = 0
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        named = dict(attributes)
        self.anchors |= {named[key] for key in ("id", "name") if named.get(key)}
        if tag == "a" and named.get("href"):
            self.links.append(named["href"])
        if named.get("src") or tag == "link" and named.get("rel") in ("stylesheet", "icon"):
            self.loaded.append(named.get("src") or named["href"])
        self.inside += tag == "article"
        if self.inside and not (tag == "table" and "highlighttable" in named.get("class", "")):
            self.tags.append(tag)

    def handle_endtag(self, tag):
        self.inside -= tag == "article"


def read(site: Path) -> dict:
    return {str(path.relative_to(site)): Page(path.read_text(encoding="utf-8")) for path in site.rglob("*.html")}


def dead(site: Path, pages: dict) -> list:
    """Links and loads that lead nowhere; those to the world are not followed."""
    found = []
    for name, page in pages.items():
        for link in page.links + page.loaded:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            base = "" if name == "404.html" else posixpath.dirname(name)
            path = posixpath.normpath(posixpath.join(base, unquote(parts.path).lstrip("/"))) if parts.path else name
            path = posixpath.join(path, "index.html") if (site / path).is_dir() else path
            anchor = unquote(parts.fragment)
            if not (site / path).is_file() or anchor and path in pages and anchor not in pages[path].anchors:
                found.append(f"{name}: {link}")
    return found


@pytest.fixture(scope="session")
def site(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    done = subprocess.run([TREE / "tools/site/build", os.environ["DREHGEBER"], folder], text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=80,
                          env=os.environ | {"DREHGEBER_SITE_ENV": sys.prefix}, check=False)
    assert (done.returncode, done.stdout) == (0, "")
    return folder


@pytest.fixture(scope="session")
def pages(site) -> dict:
    return read(site)


def name_of(page: str) -> str:
    """Where a page of the tree is in the site."""
    return re.sub(r"README\.md$", "index.md", page).removesuffix(".md") + ".html"


def test_no_link_is_dead(site, pages):
    assert len(pages) > 2 * len(PAGES)
    assert dead(site, pages) == []


def test_dead_links_are_found(tmp_path):
    (tmp_path / "folder").mkdir()
    (tmp_path / "a.html").write_text('<p id="here"><a href="folder/b.html#there">1</a><a href="#here">2</a>'
                                     '<a href="#gone">3</a><a href="folder">4</a><img src="c.svg">')
    (tmp_path / "folder/b.html").write_text('<a href="../a.html#here">5</a><a href="../a.html#there">6</a>')
    assert dead(tmp_path, read(tmp_path)) == ["a.html: folder/b.html#there", "a.html: #gone", "a.html: folder",
                                              "a.html: c.svg", "folder/b.html: ../a.html#there"]


def test_nothing_is_loaded_from_elsewhere(pages):
    assert [f"{name}: {link}" for name, page in pages.items() for link in page.loaded if urlsplit(link).netloc] == []


@pytest.mark.parametrize("page", PAGES)
def test_page_shows_what_its_text_says(pages, page):
    """Two readers of Markdown, one result: as many tables, rows, items and blocks as by CommonMark."""
    text = (TREE / page).read_text(encoding="utf-8")
    tokens = MarkdownIt("commonmark").enable("table").parse(text)
    wanted = {tag: sum(token.tag == tag and token.nesting == 1 for token in tokens) for tag in ("table", "tr", "li")}
    shown = pages[name_of(page)].tags
    made = re.search(r"<!-- made: |^::: ", text, re.M)
    for tag, count in wanted.items():
        assert (shown.count(tag) >= count) if made else (shown.count(tag) == count), tag


def test_pictures_are_of_runs(site):
    text = html.unescape((site / "docs/traces.html").read_text(encoding="utf-8"))
    for said in ("register 78h is asked for on CDM, 04 00 CC 15 comes back on CDS", "ST 524288</text>",
                 "Initiate upload response", "NMT: Start remote node", "SYNC", "OD main-index", "3/4  wheel"):
        assert said in text, said


def test_picture_of_the_tree_is_that_of_the_program():
    """python3 tools/site/made.py writes it."""
    code = "import made, waveform; print(waveform.alone(waveform.frame_picture(made._biss_lines('0x78', '4'))), end='')"
    made = subprocess.run([sys.executable, "-B", "-c", code], text=True, stdout=subprocess.PIPE, check=True, timeout=60,
                          cwd=TREE / "tools/site").stdout
    assert made == (TREE / "docs/biss.svg").read_text(encoding="utf-8")


def test_figures_are_those_of_the_run(tmp_path):
    """What tools/check leaves, in small."""
    output = {"release": {"conformance.biss": "all  375 of 376 clauses, 303 rows; 1 clauses do not hold, and are listed",
                          "power.loss": "power loss: 36400000 states, 24200000 of them inside a recovery"},
              "mutation": {"mutation.sample": "mutation score 95.0 %: 57 of 60 killed"},
              "fuzz": {"fuzz.biss": "fuzz_biss: 85 inputs, 12000 new executions (floor 100), 574 edges (floor 500)"}}
    for tree, cases in output.items():
        rows = "".join(f'<testcase name="{name}" status="run"><system-out>{text}</system-out></testcase>'
                       for name, text in cases.items())
        (tmp_path / f"{tree}.xml").write_text(f"<testsuite>{rows}</testsuite>")
    figures = tmp_path.parent / "size-m4/tests/bench"
    figures.mkdir(parents=True)
    (figures / "cortex-m4.figures").write_text("cortex-m4\nf3668.flash 20860\nf3668.ram 1234\nf3668-control.flash 50596 52101.5 -\n")
    code = "import made; print(*(made.make(name, []) for name in ('trees', 'conformance', 'power', 'mutation', 'fuzzing', " \
           "'sizes')), made.make('tests', ['power.']), sep='\\n')"
    said = subprocess.run([sys.executable, "-B", "-c", code], text=True, stdout=subprocess.PIPE, check=True, timeout=60,
                          cwd=TREE / "tools/site", env=os.environ | {"DREHGEBER_LOG": str(tmp_path)}).stdout
    for row in ("| `release` | 2 | 2 |", "| `biss` | 375 | 376 | 303 | 1 |", "**36 400 000 states**, 24 200 000 of",
                "**95.0 %**: 57 of 60", "| `biss` | 85 | 12 000 | 574 |", "| `ssi` | not in this run |",
                "| cortex-m4 | `f3668` | 20 860 | 1 234 |",
                "| cortex-m4 | `f3668-control` | 50 596 |  |", "| `power.loss` | passed |"):
        assert row in said, said


@pytest.fixture(scope="session")
def search(site):
    """search(words): locations, best first, by the index and in the way of the page's own script: every word, also
    as the beginning of a longer one; what has all of them before what has some."""
    index = json.loads((site / "search/search_index.json").read_text(encoding="utf-8"))
    fields = [{"field_name": name, "boost": field["boost"]} for name, field in index["config"]["fields"].items()
              if name != "tags"]
    for document in index["docs"]:
        for name in ("title", "text"):
            plain = html.unescape(re.sub(r"<[^>]*>", " ", document[name]))
            document[name] = re.sub(index["config"]["separator"], " ", plain)
    found_by = lunr(ref="location", fields=fields, documents=index["docs"], languages="en")

    def ask(words: str) -> list:
        return [row["ref"] for row in found_by.search(" ".join(f"{word} {word}*" for word in words.split()))]

    return ask


@pytest.mark.parametrize("question, answer", QUESTIONS.items())
def test_search_answers(search, question, answer):
    found = search(question)
    assert any(place.startswith(answer) for place in found[:3]), found[:10]
