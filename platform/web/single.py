# SPDX-License-Identifier: MIT
"""The playground in one file, drehgeber.html, which needs no server: browsers load no modules from file://. And its
module packed, as the pages beside it load it.

usage: single.py FOLDER"""

import base64
import gzip
import re
import sys
from pathlib import Path

# Each uses those before it only.
MODULES = ("parts", "engine", "rig", "biss", "figures", "masters", "view", "page", "link", "main")
IMPORT = re.compile(r'^import \{[^}]*\} from "\./\w+\.js";\n', re.MULTILINE)
COMMENT = re.compile(r"^ *//.*\n", re.MULTILINE)  # the module's own files have them, and are beside the page
INDENT = re.compile(r"^ +", re.MULTILINE)  # no text of a module is longer than a line
EXPORT = re.compile(r"^export (?=const|class|function|async)", re.MULTILINE)


def script(folder: Path) -> str:
    """The modules as one, in which a name of the top level means one thing."""
    texts = [(folder / f"{name}.js").read_text(encoding="utf-8") for name in MODULES]
    return "".join(INDENT.sub("", COMMENT.sub("", EXPORT.sub("", IMPORT.sub("", text)))) for text in texts)


def replaced(page: str, what: str, by: str) -> str:
    """Exactly one of them."""
    if page.count(what) != 1:
        sys.exit(f"single.py: index.html has {page.count(what)} of {what}; expected 1")
    return page.replace(what, by)


def main() -> None:
    """Write it beside its parts."""
    folder = Path(sys.argv[1])
    packed = gzip.compress((folder / "drehgeber.wasm").read_bytes(), mtime=0)
    (folder / "drehgeber.wasm.gz").write_bytes(packed)
    code = base64.b64encode(packed).decode()
    page = (folder / "index.html").read_text(encoding="utf-8")
    style = INDENT.sub("", (folder / "style.css").read_text(encoding="utf-8"))
    page = replaced(page, '<link rel="stylesheet" href="style.css">', f"<style>\n{style}</style>")
    inside = f'<script type="text/plain" id="module">{code}</script>\n<script type="module">\n{script(folder)}</script>'
    page = replaced(page, '<script type="module" src="main.js"></script>', inside)
    (folder / "drehgeber.html").write_text(page, encoding="utf-8")


main()
