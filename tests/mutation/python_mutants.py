# SPDX-License-Identifier: MIT
"""Finds what can be broken in a Python source: the same kinds as in C, by its syntax tree.

Texts, annotations and decorators stay. mutmut and cosmic-ray do the like, with a runner, a cache and a score of their
own, which would stand beside those of the C sources.
"""

import ast
import re

RELATION = re.compile(r"not\s+in\b|is\s+not\b|\bin\b|\bis\b|==|!=|<=|>=|<|>")
RELATED = {"==": "!=", "!=": "==", "<": "<=", "<=": "<", ">": ">=", ">=": ">", "in": "not in", "not in": "in",
           "is": "is not", "is not": "is"}


class Text:
    """Places of a syntax tree as places in the text."""

    def __init__(self, text):
        self.text = text
        self.lines = text.splitlines(keepends=True)
        self.begins = [0]
        for line in self.lines:
            self.begins.append(self.begins[-1] + len(line))

    def place(self, line, column):
        return self.begins[line - 1] + len(self.lines[line - 1].encode()[:column].decode())

    def begin(self, node):
        return self.place(node.lineno, node.col_offset)

    def end(self, node):
        return self.place(node.end_lineno, node.end_col_offset)

    def of(self, node):
        return self.text[self.begin(node): self.end(node)]


def relations(node, source):
    if isinstance(node, ast.Compare):
        for left, right in zip([node.left, *node.comparators], node.comparators):
            begin = source.end(left)
            match = RELATION.search(source.text, begin, source.begin(right))
            yield match.start(), match.end(), RELATED[" ".join(match.group().split())]


def constants(node, source):
    if not isinstance(node, ast.Constant) or not isinstance(node.value, int):
        return
    before = source.of(node)
    if isinstance(node.value, bool):
        yield source.begin(node), source.end(node), str(not node.value)
        return
    for other in (node.value + 1, node.value - 1):
        if other >= 0:
            after = f"0x{other:0{len(before) - 2}X}" if before[:2].lower() == "0x" else str(other)
            yield source.begin(node), source.end(node), after


def conditions(node, source):
    tests = [node.test] if isinstance(node, (ast.If, ast.While, ast.IfExp)) else getattr(node, "ifs", [])
    for test in tests:
        yield source.begin(test), source.end(test), f"(not ({source.of(test)}))"


def statements(node, source):
    changes = isinstance(node, (ast.AugAssign, ast.Raise, ast.Break, ast.Continue, ast.Delete))
    changes |= isinstance(node, ast.Expr) and isinstance(node.value, (ast.Call, ast.Await))
    changes |= isinstance(node, ast.Assign) and isinstance(node.targets[0], (ast.Attribute, ast.Subscript))
    changes |= isinstance(node, ast.Return) and node.value is None
    if changes:
        yield source.begin(node), source.end(node), "pass" + "\n" * (node.end_lineno - node.lineno)


def rows(node, source):
    """Of a dictionary with a line for each."""
    if isinstance(node, ast.Dict) and len({value.lineno for value in node.values}) > 1:
        for key, value in zip(node.keys, node.values):
            comma = re.compile(r"\s*,").match(source.text, source.end(value))
            if key and comma:
                begin, end = source.begin(key), comma.end()
                yield begin, end, "\n" * source.text.count("\n", begin, end)


KINDS = {"relation": relations, "constant": constants, "statement": statements, "condition": conditions, "row": rows}


def walk(node):
    """The nodes that may be broken."""
    if isinstance(node, (ast.JoinedStr, ast.arg)):  # whose parts have no places before Python 3.12; an annotation
        return
    yield node
    for name, value in ast.iter_fields(node):
        if name not in ("annotation", "returns", "decorator_list"):
            for child in value if isinstance(value, list) else [value]:
                if isinstance(child, ast.AST):
                    yield from walk(child)


def find(text):
    """(kind, begin, end, what takes its place) of all mutants"""
    source = Text(text)
    for node in walk(ast.parse(text)):
        for kind, finder in KINDS.items():
            for begin, end, after in finder(node, source):
                yield kind, begin, end, after


def blocks(text):
    """First and last lines of all functions and methods."""
    return [(node.lineno, node.end_lineno) for node in ast.walk(ast.parse(text))
            if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))]


def object_code(text):
    """What the compiler makes of it, without places; None of what does not compile."""

    def plain(code):
        parts = [plain(part) if hasattr(part, "co_code") else repr(part) for part in code.co_consts]
        return code.co_code, code.co_names, code.co_varnames, parts

    try:
        return plain(compile(text, "mutant", "exec", dont_inherit=True))
    except (SyntaxError, ValueError):
        return None
