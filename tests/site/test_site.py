# SPDX-License-Identifier: MIT
"""The site as it is built for readers: no warning, no dead link, nothing from elsewhere, what pages say."""
import base64
import html
import json
import os
import posixpath
import re
import shutil
import struct
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest
from markdown_it import MarkdownIt

TREE = Path(__file__).resolve().parents[2]
sys.path.append(str(TREE / "tests/gates"))
from sources import files  # noqa: E402

LEFT_OUT = (".github/", ".gitlab/")
SOURCES = "https://forge.invalid/drehgeber"
PAGES = [page for page in files(str(TREE), suffixes=(".md",)) if not page.startswith(LEFT_OUT)]


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
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=180,
                          env=os.environ | {"DREHGEBER_SITE_ENV": sys.prefix, "DREHGEBER_REPOSITORY": SOURCES}, check=False)
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


def test_picture_of_gtkwave_shows_something(site):
    """An empty window is 3 kB."""
    page = (site / "docs/traces.html").read_text(encoding="utf-8")
    picture = base64.b64decode(re.search(r'src="data:image/png;base64,([^"]+)"', page)[1])
    assert struct.unpack(">8x4x4sII", picture[:24]) == (b"IHDR", 1200, 220)
    assert len(picture) > 10_000


def test_playground_is_in_the_menu(site, pages):
    assert "playground/index.html" in pages["index.html"].links
    assert "../../playground/index.html" in pages["platform/web/index.html"].links
    assert (site / "playground/drehgeber.wasm").stat().st_size > 100_000
    assert not list((site / "playground").glob("screenshot*"))


def of_theme(names):
    """Pages that are made of text."""
    return [name for name in names if not name.startswith("playground/")]


def test_every_page_has_logo_and_sources(pages):
    for name in of_theme(pages):
        root = "/" if name == "404.html" else posixpath.relpath(".", posixpath.dirname(name) or ".") + "/"
        assert posixpath.normpath(root + "logo.svg") in map(posixpath.normpath, pages[name].loaded), name
        assert SOURCES in pages[name].links, name


def test_the_first_page_shows_the_playground(pages):
    assert "playground/drehgeber.html" in pages["index.html"].loaded
    assert "playground/index.html" in pages["index.html"].links


def versions(folder):
    return subprocess.run([TREE / "tools/site/versions", folder], text=True, capture_output=True, timeout=60, check=False)


def test_sites_of_several_versions(tmp_path):
    """Newest first by number, not by letters; what is no version is left out."""
    for name in ("0.3.0", "1.0.0", "0.10.0", "draft"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "index.html").write_text("")
    (tmp_path / "2.0.0").mkdir()
    assert (versions(tmp_path).returncode, versions(tmp_path).stdout) == (0, "1.0.0 0.10.0 0.3.0\n")
    rows = json.loads((tmp_path / "versions.json").read_text())
    assert [(row["version"], row["aliases"]) for row in rows] == [("1.0.0", ["latest"]), ("0.10.0", []), ("0.3.0", [])]
    assert 'href="1.0.0/index.html"' in (tmp_path / "index.html").read_text()
    refused = versions(tmp_path / "draft")
    assert (refused.returncode, "expected 1.0.0/index.html" in refused.stderr) == (1, True)


def test_every_page_of_each_version_has_the_switch(site, pages, tmp_path):
    """Once, also when it is asked for again. All other files stay as they are."""
    folders = [tmp_path / name for name in ("0.3.0", "1.0.0")]
    for folder in folders:
        shutil.copytree(site, folder)
    assert versions(tmp_path).returncode == versions(tmp_path).returncode == 0
    files_of_site = [path.relative_to(site) for path in site.rglob("*") if path.is_file()]
    for folder in folders:
        changed = [name for name in files_of_site if (folder / name).read_bytes() != (site / name).read_bytes()]
        assert sorted(map(str, changed)) == sorted(of_theme(pages))
        for name in changed:
            assert (folder / name).read_text(encoding="utf-8").count('"version": {"provider": "mike"}') == 1, name


@pytest.mark.parametrize("picture", ["docs/biss.svg", "docs/drehgeber.svg"])
def test_pictures_of_the_tree_are_those_of_the_program(picture):
    """DREHGEBER=... python3 tools/site/made.py writes them."""
    code = f"import made; print(made.PICTURES['{picture}'](), end='')"
    made = subprocess.run([sys.executable, "-B", "-c", code], text=True, stdout=subprocess.PIPE, check=True, timeout=60,
                          cwd=TREE / "tools/site").stdout
    assert made == (TREE / picture).read_text(encoding="utf-8")


def test_the_screen_of_top_has_the_words_of_the_program():
    """Numbers and the hands of the dials are of another moment each time, so that the page has those of one run."""
    def words(screen):
        lasting = screen.partition("last frames on this wire")[0]
        return [re.findall(r"[A-Za-z_][\w:]*", line) for line in lasting.splitlines()]

    code = "import made; print(made.top(), made.SCREEN.search(made.SCREEN_PAGE.read_text(encoding='utf-8'))[0], sep='=====', end='')"
    made, written = subprocess.run([sys.executable, "-B", "-c", code], text=True, stdout=subprocess.PIPE, check=True, timeout=60,
                                   cwd=TREE / "tools/site").stdout.split("=====", 1)
    assert ["ring", "ocd", "ib", "k3", "modbus", "UL:on", "RC:on", "BA:on", "RD:off", "position"] in words(written)
    assert words(made) == words(written)


def test_figures_are_those_of_the_run(tmp_path):
    """What tools/check leaves, in small."""
    output = {"release": {"conformance.biss": "all  375 of 376 clauses, 303 rows; 1 clauses do not hold, and are listed",
                          "power.loss": "power loss: 36400000 states, 24200000 of them inside a recovery"},
              "mutation": {"mutation.sample": "mutation score of src: 95.0 %, 57 of the last 60 killed"},
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
