# SPDX-License-Identifier: MIT
"""The fenced blocks of a page, and the marks above them.

What is done with a block depends on its language: one of COMMANDS is run, any other, or none, is
what the block before it in the same section prints; `...` stands for anything. A block without a
language that follows none is a drawing. Marks are HTML comments right above a block:

  <!-- run: guest -->            the rig guest runs it (test rig.docs)
  <!-- run: elsewhere, NAME -->  NAME runs it: a test of ctest, or a file of the tree
  <!-- file: NAME -->            the reader saves it as NAME; a later block of the page uses it
"""
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Optional

from markdown_it import MarkdownIt

# The shell command that runs the block in FILE; all of them begin in the root of the tree.
COMMANDS = {
    "sh":     ". FILE",
    "python": "python3 FILE",
    "c":      "cc -std=c11 -Wall -Wextra -Werror -Iinclude FILE -o FILE.out"
              " build/quickstart/libdrehgeber.a && FILE.out",
    "ini":    "background drehgeber run FILE",
}
GUEST_TEST = "rig.docs"
MARK = re.compile(r"<!--\s*(run|file):\s*(.*?)\s*-->")
RUN_MARK = re.compile(r"(guest)|elsewhere, (\S+)")


class PageError(Exception):
    """What is wrong, with page and line."""


@dataclass(frozen=True)
class Block:
    page: str
    line: int             # of its text, from 1
    path: tuple           # the headings it is below, as (level, line)
    language: str
    text: str = field(repr=False)
    where: str            # here, guest or elsewhere
    by: Optional[str]     # who runs it, unless it is run here
    file: Optional[str]
    prints: Optional["Block"]  # the block whose output this is

    def error(self, what: str) -> PageError:
        return PageError(f"{self.page}:{self.line}: {what}")

    def is_run(self) -> bool:
        return self.file is None and self.language in COMMANDS


def _where(mark: Optional[str]) -> tuple:
    """Where a block runs and by whom; None when the mark says neither."""
    if mark is None:
        return "here", None
    match = RUN_MARK.fullmatch(mark)
    if match is None:
        return None, None
    return ("guest", GUEST_TEST) if match[1] else ("elsewhere", match[2])


def _refuse(block: Block, marks: dict):
    """What a block cannot be."""
    silent = block.language not in COMMANDS and block.file is None
    if block.where is None:
        raise block.error(f"'run: {marks['run']}' is neither 'guest' nor 'elsewhere, NAME'")
    if "run" in marks and block.where != "elsewhere" and silent:
        raise block.error("only what can be run has a 'run' mark; output is marked by its block")
    if block.language and silent and not block.prints and not marks:
        raise block.error(f"'{block.language}' cannot be run, and no block before it in this section "
                          f"could print it; can be run: {', '.join(COMMANDS)}")


def _make(page: str, token, path: tuple, marks: dict, earlier: list) -> Block:
    language = (token.info.split() or [""])[0]
    where, by = _where(marks.get("run"))
    prints = None
    if language not in COMMANDS and not marks:
        runs = [block for block in earlier if block.path == path and block.is_run()]
        prints = runs[-1] if runs else None
        where = prints.where if prints else where
    block = Block(page, token.map[0] + 2, path, language, token.content, where, by,
                  marks.get("file"), prints)
    _refuse(block, marks)
    return block


def parse(page: str, text: str) -> list:
    """All blocks in order."""
    blocks, marks, path = [], {}, ()
    for token in MarkdownIt("commonmark").parse(text):
        mark = MARK.fullmatch(token.content.strip()) if token.type == "html_block" else None
        if mark:
            marks[mark[1]] = mark[2]
            continue
        if token.type == "fence":
            blocks.append(_make(page, token, path, marks, blocks))
        elif marks:
            raise PageError(f"{page}:{token.map[0] + 1 if token.map else '?'}: "
                            f"a mark belongs right above a block, this follows {marks}")
        elif token.type == "heading_open":
            level = int(token.tag[1:])
            path = (*(at for at in path if at[0] < level), (level, token.map[0] + 1))
        marks = {}
    if marks:
        raise PageError(f"{page}: a mark belongs right above a block, nothing follows {marks}")
    return blocks


def _is_called(block: Block, tree: Path) -> bool:
    """The file that runs this block names the block's command."""
    file = tree / block.by
    return file.is_file() and block.text.split()[0] in file.read_text(encoding="utf-8")


def check(blocks: list, tree: Path, tests: list):
    """Who is said to run a block exists, and a saved file is used."""
    for number, block in enumerate(blocks):
        if block.by and block.by not in tests and not _is_called(block, tree):
            raise block.error(f"'{block.by}' is no test of ctest, and no file of the tree with "
                              f"{block.text.split()[0]} in it")
        name = rf"\b{re.escape(Path(block.file or '').stem)}\b"
        used = [later for later in blocks[number + 1:]
                if later.where == block.where and re.search(name, later.text)]
        if block.file and not used:
            raise block.error(f"no later block uses {block.file}")


def matches(wanted: str, output: str) -> bool:
    """`output` has the lines of `wanted`; `...` is anything, as a line of its own also lines."""
    rows = []
    for row in wanted.strip("\n").split("\n"):
        words = [re.escape(word) for word in row.rstrip().split("...")]
        anything = row.strip() == "..."
        rows.append(r"(?:.*\n)*?" if anything else ".*".join(words) + r"[ \t]*(?:\n|\Z)")
    return re.search("(?m)^" + "".join(rows), output) is not None
