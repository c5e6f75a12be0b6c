# SPDX-License-Identifier: MIT
"""Finds what can be broken in a source: one small change each, of five kinds; and draws some of it.

In C it works on the text, not on a syntax tree: what does not compile is dropped by the runner. Comments,
strings, directives other than #define, static assertions and the sizes of declared arrays stay. Python is
broken by python_mutants.
"""

import hashlib
import re
from typing import NamedTuple

import python_mutants


class Mutant(NamedTuple):
    path: str
    line: int
    kind: str
    begin: int  # characters of the file that are replaced
    end: int
    after: str

    def apply(self, text):
        return text[: self.begin] + self.after + text[self.end:]

    def lines(self, text):
        """The first line that differs: its number, before and after."""
        pairs = zip(text.split("\n"), self.apply(text).split("\n"))
        for number, (before, after) in enumerate(pairs, 1):
            if before != after:
                return number, " ".join(before.split()), " ".join(after.split())
        return self.line, "", ""


HIDDEN = re.compile(
    r"/\*.*?\*/|//[^\n]*"
    r'|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\''
    r"|^[ \t]*#(?!\s*define)(?:\\\n|[^\n])*"
    r"|^[ \t]*#\s*define \w+(?:\([^)\n]*\))?"
    r"|\b_Static_assert\b[^;]*;",
    re.S | re.M,
)
DECLARED_SIZE = re.compile(r"^[ \t]*(?:(?:static|const|struct|enum|unsigned)\s+)*\w+[ \t]+\**\w+((?:\[[^]\n]*\])+)", re.M)

RELATION = re.compile(r"(?<![<>=!&|+*/%^-])(<=|>=|==|!=|<|>)(?![<>=])")
RELATED = {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "=="}
CONSTANT = re.compile(r"(?<![\w.])(0[xX][0-9A-Fa-f]+|\d+)([uUlL]*)(?![\w.])")
CONDITION = re.compile(r"\b(?:if|while) \(")
STATEMENT = re.compile(r"(?<=[;{}:\n])[ \t]*\n?^[ \t]+((?:\(void\))?[A-Za-z_*(][^;{}#]*;)[ \t]*(?=\n)", re.M)
DECLARATION = re.compile(r"(?:(?:static|const|struct|enum|unsigned|volatile)\b|\w+[ \t\n]+\**\w+[ \t\n]*(?:\[|=|;|,))")
CONTROL = re.compile(r"(?:return\b(?!;)|if\b|else\b|for\b|while\b|do\b|switch\b|case\b|default\b|goto\b|typedef\b)")
CALL = re.compile(r"(?:\(void\))?[\w>.\-\[\]*]+\(")
CHANGE = re.compile(r"[^=!<>]=[^=]|\+\+|--")
ROW = re.compile(r"^[ \t]*(?:\[[^]\n]+\][ \t]*=[ \t]*)?\{[^;\n]*\},?[ \t]*$", re.M)
DEF_ROW = re.compile(r"^[A-Z][A-Z0-9_]*\([^\n]*\)[ \t]*$", re.M)


def hide(text):
    """`text` with all that is not to be changed blanked; every character keeps its place."""

    def spaces(match):
        return re.sub(r"[^\n]", " ", match.group())

    def sizes(match):
        head = match.group()[: match.start(1) - match.start()]
        return head + re.sub(r"\w", " ", match.group(1))

    return DECLARED_SIZE.sub(sizes, HIDDEN.sub(spaces, text))


def closing(code, begin):
    """Index of the bracket that closes the one at `begin`, or None."""
    depth = 0
    for match in re.compile(r"[()]").finditer(code, begin):
        depth += 1 if match.group() == "(" else -1
        if depth == 0:
            return match.start()
    return None


def relations(code):
    for match in RELATION.finditer(code):
        yield match.start(), match.end(), RELATED[match.group()]


def constants(code):
    for match in CONSTANT.finditer(code):
        digits, suffix = match.groups()
        value = int(digits, 0) if digits == "0" or digits[0] != "0" or digits[1] in "xX" else int(digits)
        for other in (value + 1, value - 1):
            if other >= 0:
                text = f"0x{other:0{len(digits) - 2}X}" if "x" in digits.lower() else str(other)
                yield match.start(), match.end(), text + suffix


def conditions(code):
    for match in CONDITION.finditer(code):
        end = closing(code, match.end() - 1)
        if end is not None:
            yield match.end() - 1, end + 1, None


def statements(code):
    for match in STATEMENT.finditer(code):
        text = match.group(1)
        before = code[: match.start(1)].rstrip()
        if before[-1:] not in tuple(";{}:") or DECLARATION.match(text) or CONTROL.match(text):
            continue
        if text in ("break;", "continue;", "return;") or CALL.match(text) or CHANGE.search(text):
            yield match.start(1), match.end(1), ";"


def rows(code):
    for pattern in (ROW, DEF_ROW):
        for match in pattern.finditer(code):
            yield match.start(), match.end(), ""


KINDS = {
    "relation": relations,
    "constant": constants,
    "statement": statements,
    "condition": conditions,
    "row": rows,
}


def find(path, text):
    """All mutants of a file."""
    if path.endswith(".py"):
        return [Mutant(path, text.count("\n", 0, begin) + 1, *each) for each in python_mutants.find(text)
                for begin in [each[1]]]
    code = hide(text)
    found = []
    for kind, finder in KINDS.items():
        for begin, end, after in finder(code):
            if kind == "row" and path.endswith(".c") != text[begin:end].lstrip().startswith(("{", "[")):
                continue
            if after is None:
                after = f"(!{text[begin:end]})"
            elif after in ("", ";"):
                after += "\n" * text.count("\n", begin, end)  # lines keep their numbers
            line = text.count("\n", 0, begin) + 1
            found.append(Mutant(path, line, kind, begin, end, after))
    return found


# A function or a table: from a line that begins at the margin to the brace that ends there.
BLOCK = re.compile(r"^[A-Za-z_][^;{}]*?\{.*?^\}", re.S | re.M)


def blocks(path, text):
    """First and last lines of what a change of a line in it may change."""
    if path.endswith(".py"):
        return python_mutants.blocks(text)
    places = [(match.start(), match.end()) for match in BLOCK.finditer(text)]
    return [(text.count("\n", 0, begin) + 1, text.count("\n", 0, end) + 1) for begin, end in places]


def digest(*parts):
    return hashlib.sha256("|".join(map(str, parts)).encode()).digest()


def draw(mutants, texts, seed):
    """One mutant of each line, in the order of the seed. Line, kind and mutant are drawn by their
    text, not by their place: the sample stays when other lines are changed."""
    lines = {}
    for mutant in mutants:
        lines.setdefault((mutant.path, mutant.line), []).append(mutant)
    split = {path: text.split("\n") for path, text in texts.items()}
    seen = {}
    ranked = []
    for (path, line), choice in sorted(lines.items()):
        text = split[path][line - 1].strip()
        again = seen[path, text] = seen.get((path, text), 0) + 1
        key = (seed, path, text, again)
        kind = min({mutant.kind for mutant in choice}, key=lambda kind: digest(*key, kind))
        same = [mutant for mutant in choice if mutant.kind == kind]
        chosen = min(enumerate(same), key=lambda each: digest(*key, kind, each[0]))[1]
        ranked.append((digest(*key), chosen))
    return [mutant for _, mutant in sorted(ranked)]
