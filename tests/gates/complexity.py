# SPDX-License-Identifier: MIT
"""Length and complexity of functions and files in C, Python and JavaScript, measured by lizard; macros are
held to what functions are, and sources in other languages to the length of a file.

usage: complexity.py TREE
"""

import ast
import re
import sys

import lizard

from sources import blank, files, finish, read

# what                in src  elsewhere  95 % of the product's at most, in each language
LENGTH           =    (40,     50,        30)
COMPLEXITY       =    (14,     17,         8)
COMPLEXITY_MEAN  = 3.5
PARAMETERS       = 6 # in Python those that are not always named
PARAMETERS_PUBLIC = 5
FILE_LINES       = 700
FILE_LINES_TESTS = 800 # in Python and JavaScript: a list of tests that do not know each other

FOLDERS = ("src", "platform", "tools", "tests")
# ending: what lizard reads it as; None has lines only
READ_AS = {".c": ".c", ".h": ".c", ".def": ".c", ".cpp": ".cpp", ".py": ".py", ".js": ".js", ".mjs": ".js",
           ".v": None, ".vh": None, ".sv": None, ".svh": None, ".vhd": None, ".S": None, ".sh": None}
LONGER_TESTS = (".py", ".js", ".mjs")
MACRO = re.compile(r"^[ \t]*#[ \t]*define[ \t]+(\w+)((?:[^\\\n]|\\\n|\\.)*)", re.M)
BRANCH = re.compile(r"\b(?:if|for|while|case)\b|&&|\|\||\?")


def sources(tree):
    """Path, ending and text of every source. A program without an ending says in its first line what it is."""
    for path in files(tree, *FOLDERS):
        _, dot, kind = path.rsplit("/", 1)[-1].rpartition(".")
        if dot and dot + kind in READ_AS:
            yield path, dot + kind, read(tree, path)
        elif not dot and not path.startswith("tests/fuzz/corpus/"):
            text = read(tree, path)
            if text.startswith("#!"):
                yield path, ".py" if "python3" in text.split("\n", 1)[0] else ".sh", text


def positional(text):
    """Line of each function in Python: its parameters that a caller need not name, without the object."""
    return {node.lineno: sum(one.arg not in ("self", "cls") for one in node.args.posonlyargs + node.args.args)
            for node in ast.walk(ast.parse(text)) if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))}


def functions_of(path, language, text):
    """What lizard knows of each function, under the path it has in the tree."""
    found = lizard.analyze_file.analyze_source_code(path + language, text).function_list
    named = positional(text) if language == ".py" else {}
    for function in found:
        function.filename = path
        function.parameters_at_most = named.get(function.start_line, function.parameter_count)
    return found


def macros(path, text):
    """Complaints about macros as long or as branched as a function must not be."""
    bare = blank(text)
    for match in MACRO.finditer(bare):
        at, lines = bare.count("\n", 0, match.start()) + 1, match.group().count("\n") + 1
        complexity = 1 + len(BRANCH.findall(match.group(2)))
        for what, value, limits in (("length", lines, LENGTH), ("complexity", complexity, COMPLEXITY)):
            if value > limit(path, limits):
                yield f"{path}:{at}: macro {match.group(1)}: {what} {value}, at most {limit(path, limits)}"


def limit(path, limits):
    return limits[0] if path.startswith("src/") else limits[1]


def of_product(function):
    return not function.filename.startswith("tests/")


def each(functions, what, value, limits):
    """Complaints about one figure of each function."""
    for function in functions:
        most = limit(function.filename, limits)
        if value(function) > most:
            yield f"{function.filename}:{function.start_line}: {function.name}: {what} {value(function)}, at most {most}"


def usual(functions, what, value, most):
    """Complaints about one figure of nearly all functions of the product in a language."""
    values = sorted(map(value, functions))
    p95 = values[-(-len(values) * 95 // 100) - 1]
    print(f"{what}: mean {sum(values) / len(values):.2f}, p95 {p95}, max {values[-1]}")
    if p95 > most:
        yield f"{what}: 95 % of the functions shall have at most {most}, not {p95}"


def length(function):
    return function.end_line - function.start_line + 1


def complexity(function):
    return function.cyclomatic_complexity


def judge(language, functions, public):
    """Complaints about all functions in a language."""
    product = [function for function in functions if of_product(function)]
    for what, value, limits in (("length", length, LENGTH), ("complexity", complexity, COMPLEXITY)):
        yield from each(functions, what, value, limits)
        yield from usual(product, f"{language} {what}", value, limits[2]) if product else ()
    if sum(map(complexity, product)) > COMPLEXITY_MEAN * len(product):
        yield f"{language} complexity: mean {sum(map(complexity, product)) / len(product):.2f}, at most {COMPLEXITY_MEAN}"
    for function in functions:
        most = PARAMETERS_PUBLIC if function.name in public else PARAMETERS
        if function.parameters_at_most > most:
            yield (f"{function.filename}:{function.start_line}: {function.name}: "
                   f"{function.parameters_at_most} parameters, at most {most}")


def main():
    tree = sys.argv[1]
    headers = "".join(blank(read(tree, path)) for path in files(tree, "include"))
    public = set(re.findall(r"\b(dg_\w+)\(", headers))
    functions, complaints = {}, []
    for path, kind, text in sources(tree):
        most = FILE_LINES_TESTS if path.startswith("tests/") and kind in LONGER_TESTS else FILE_LINES
        if text.count("\n") > most:
            complaints.append(f"{path}: {text.count(chr(10))} lines, at most {most}")
        if READ_AS[kind]:
            functions.setdefault(READ_AS[kind], []).extend(functions_of(path, READ_AS[kind], text))
        if READ_AS[kind] == ".c":
            complaints += macros(path, text)
    for language, found in functions.items():
        complaints += judge(language, found, public)
    if not any(map(of_product, functions.get(".c", ()))):
        sys.exit("no functions found")
    finish(sum(map(len, functions.values())), complaints)


main()
