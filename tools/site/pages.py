# SPDX-License-Identifier: MIT
"""Hook of MkDocs: the pages of the tree are the pages of the site, at the same places, so that links between
them hold here as there. A link to a file that is no page leads to one that shows the file, a link to a folder
to its README.md, or to one that lists its files; pictures come along. `<!-- made: NAME -->` becomes what made.py
makes of that. The playground that was built with the program is in it, as it is."""

import os
import posixpath
import re
import sys
from pathlib import Path

from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File
from mkdocs.structure.nav import Link
from pathspec import PathSpec

HERE = Path(__file__).resolve().parent
TREE = HERE.parents[1]
sys.path[:0] = [str(HERE), str(TREE / "tests/gates")]
import c_api  # noqa: E402
import made  # noqa: E402
from sources import files as files_of_tree  # noqa: E402

# For who works with a forge, not with the encoders.
LEFT_OUT = (".github/", ".gitlab/")
LANGUAGES = {".py": "python", ".c": "c", ".h": "c", ".yml": "yaml", ".yaml": "yaml", ".ini": "ini", ".v": "verilog",
             ".vhd": "vhdl", ".sv": "systemverilog"}
PICTURES = (".svg", ".png")
PLAYGROUND = "playground"
BOOSTS = (("docs/c/", 0.3), ("docs/python.md", 0.5), ("docs/", 3), ("tools/python/README.md", 3),
          ("src/bus/", 0.3), ("src/host/", 0.3), ("src/rig/", 0.3), ("tests/", 0.3), ("ARCHITECTURE.md", 0.3),
          ("CONTRIBUTING.md", 0.3), ("CHANGELOG.md", 0.3))
LINK = re.compile(r"(\]\()([^)\s#]+)((?:#[^)\s]*)?\))")
FENCE = re.compile(r"^ {0,3}(```|~~~)")
MADE = re.compile(r"<!-- made: ([\w-]+)((?: [\w./-]+)*) -->")


def _shown(path: str) -> str:
    """The page of a file that is no page itself."""
    return f"{path}.md"


def _target(source: str, link: str, pages: set):
    """The page that a link leads to, from the root; None when it is nobody of the tree."""
    if re.match(r"[a-z]+:", link):
        return None
    path = posixpath.normpath(posixpath.join(posixpath.dirname(source), link))
    if path in pages or path.endswith(PICTURES) and (TREE / path).is_file():
        return path
    if (TREE / path).is_dir():
        return posixpath.join(path, "README.md")
    return _shown(path) if (TREE / path).is_file() else None


def _linked(source: str, text: str, pages: set, act) -> str:
    """`text` with what act(target) is called for in the place of each link, blocks of code aside."""
    lines, inside = [], False

    def change(match):
        target = _target(source, match[2], pages)
        if target is None:
            return match[0]
        act(target)
        return match[1] + posixpath.relpath(target, posixpath.dirname(source) or ".") + match[3]

    for line in text.split("\n"):
        inside ^= bool(FENCE.match(line))
        lines.append(line if inside else LINK.sub(change, line))
    return "\n".join(lines)


def _file_page(path: str) -> str:
    text = (TREE / path).read_text(encoding="utf-8").rstrip("\n")
    language = LANGUAGES.get(posixpath.splitext(path)[1], "")
    return f"# `{path}`\n\n`````{language}\n{text}\n`````\n"


def _folder_page(folder: str) -> str:
    rows = [f"- [{name}]({name})" for name in sorted(os.listdir(TREE / folder)) if not name.startswith((".", "__"))]
    return f"# `{folder}`\n\n" + "\n".join(rows) + "\n"


def _named(menu):
    """The pages of a menu."""
    for entry in menu:
        values = entry.values() if isinstance(entry, dict) else [entry]
        for value in values:
            yield from [value] if isinstance(value, str) else _named(value)


def _playground(config) -> list:
    """Its files, without what its tests leave there."""
    folder = Path(made.PROGRAM).parent / PLAYGROUND
    paths = sorted(path for path in folder.glob("*") if not path.name.startswith("screenshot"))
    if not any(path.name == "index.html" for path in paths):
        raise PluginError(f"{folder} has no playground: cmake --build --target playground makes it")
    return [File.generated(config, f"{PLAYGROUND}/{path.name}", abs_src_path=str(path)) for path in paths]


def on_files(files, config):
    pages = {path for path in files_of_tree(str(TREE), suffixes=(".md",)) if not path.startswith(LEFT_OUT)}
    texts = {path: (TREE / path).read_text(encoding="utf-8") for path in pages}
    texts |= c_api.pages(TREE)
    shown, pictures, waiting = set(), set(), sorted(texts)
    while waiting:
        source = waiting.pop()
        wanted = set()
        texts[source] = _linked(source, texts[source], pages, wanted.add)
        pictures |= {target for target in wanted if target.endswith(PICTURES)}
        for target in sorted(wanted - pictures - set(texts)):
            folder = posixpath.dirname(target)
            listed = posixpath.basename(target) == "README.md"
            texts[target] = _folder_page(folder) if listed else _file_page(target.removesuffix(".md"))
            shown.add(target)
            waiting += [target] if listed else []
    for path, text in sorted(texts.items()):
        files.append(File.generated(config, path, content=text))
    for path in sorted(pictures):
        files.append(File.generated(config, path, abs_src_path=str(TREE / path)))
    for file in _playground(config):
        files.append(file)
    # Who looks for a file finds it by a link; they are not in the menu. A page that the menu does not name is.
    config.extra["shown"] = shown
    hidden = shown | {path for path in texts if path.startswith("docs/c/")}
    config.not_in_nav = PathSpec.from_lines("gitwildmatch", [f"/{path}" for path in sorted(hidden)])
    more = sorted(set(texts) - hidden - set(_named(config.nav)))
    if more:
        config.nav.append({"More": more})
    return files


def _boost(path: str) -> float:
    """How much a page counts in the search: what was written for who begins most, what is for who changes something
    least."""
    return next((boost for begin, boost in BOOSTS if path.startswith(begin)), 1)


def on_nav(nav, config, files):
    """The playground is no page, and is in the menu all the same, behind the first entry."""
    nav.items.insert(1, Link("Playground", f"{PLAYGROUND}/index.html"))
    return nav


def on_page_markdown(markdown, page, config, files):
    page.meta["search"] = {"boost": _boost(page.file.src_uri)}
    if page.file.src_uri in config.extra["shown"]:
        page.meta["search"]["exclude"] = True
    return MADE.sub(lambda match: made.make(match[1], match[2].split()), markdown)
