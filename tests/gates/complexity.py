# SPDX-License-Identifier: MIT
"""Length and complexity of functions and files, measured by lizard.

usage: complexity.py TREE
"""

import re
import sys

import lizard

from sources import blank, files, finish, read

# what                in src  elsewhere  95 % of the product's at most
LENGTH           =    (40,     50,        30)
COMPLEXITY       =    (14,     17,         8)
COMPLEXITY_MEAN  = 3.5
PARAMETERS       = 6
PARAMETERS_PUBLIC = 5
FILE_LINES       = 700


def of_product(function):
    return not function.filename.startswith("tests/")


def check(functions, what, value, limits):
    """Complaints about one figure of all functions against its maximum and 95th percentile."""
    core, elsewhere, usual = limits
    complaints = []
    for function in functions:
        most = core if function.filename.startswith("src/") else elsewhere
        if value(function) > most:
            complaints.append(f"{function.filename}:{function.start_line}: {function.name}: {what} "
                              f"{value(function)}, at most {most}")
    values = sorted(value(function) for function in functions if of_product(function))
    p95 = values[-(-len(values) * 95 // 100) - 1]
    print(f"{what}: mean {sum(values) / len(values):.2f}, p95 {p95}, max {values[-1]}")
    if p95 > usual:
        complaints.append(f"{what}: 95 % of the functions shall have at most {usual}, not {p95}")
    return complaints


def main():
    tree = sys.argv[1]
    headers = "".join(blank(read(tree, path)) for path in files(tree, "include"))
    public = set(re.findall(r"\b(dg_\w+)\(", headers))
    folders = ("src", "platform", "tools", "tests")
    functions, complaints = [], []
    for path in files(tree, *folders, suffixes=(".c", ".h")):
        text = read(tree, path)
        if text.count("\n") > FILE_LINES:
            complaints.append(f"{path}: {text.count(chr(10))} lines, at most {FILE_LINES}")
        functions += lizard.analyze_file.analyze_source_code(path, text).function_list
    product = [function for function in functions if of_product(function)]
    if not product:
        sys.exit("no functions found")
    complaints += check(functions, "length", lambda f: f.end_line - f.start_line + 1, LENGTH)
    complaints += check(functions, "complexity", lambda f: f.cyclomatic_complexity, COMPLEXITY)
    mean = sum(f.cyclomatic_complexity for f in product) / len(product)
    if mean > COMPLEXITY_MEAN:
        complaints.append(f"complexity: mean {mean:.2f}, at most {COMPLEXITY_MEAN}")
    for function in functions:
        most = PARAMETERS_PUBLIC if function.name in public else PARAMETERS
        if function.parameter_count > most:
            complaints.append(
                f"{function.filename}:{function.start_line}: {function.name}: "
                f"{function.parameter_count} parameters, at most {most}"
            )
    finish(len(functions), complaints)


main()
