# SPDX-License-Identifier: MIT
"""What a header declares is documented: every function, variable, struct, enum, typedef and macro
with a value. A comment has words, and opens the block of lines it stands in, or stands behind it on its
line. A block ends at an empty line, so that one comment can speak for several similar things, but not for
functions: each has its own. Members and values are the comment of their struct or enum's business.

usage: documented.py TREE
"""

import re
import sys

from sources import blank, files, finish, read

# In public headers, and in those of ports, whose functions and variables speak for themselves.
DATA = r"(?:struct|enum|union)(?: (\w+))?(?= \{)|typedef\b[^;]*?\b(\w+)(?=[;)])|# *define (\w+)(?=[( ])"
DECLARED = re.compile(rf"^(?:{DATA}|(?!struct \w+(?: \{{|;)|enum)\w[\w \*]*\b(dg_\w+)(?=\(|\[|;))")
PLATFORM = re.compile(rf"^(?:{DATA})")
WORDLESS = re.compile(r"/\*(?:(?!\*/)\W)*\*/")


def complaints_of(path, text, declared):
    """How much is declared, and complaints."""
    text = WORDLESS.sub(lambda comment: "\n" * comment.group().count("\n"), text)
    raw, bare = text.split("\n"), blank(text).split("\n")
    complaints, checked = [], 0
    documented, own, inside, continued = False, False, False, False
    for number, line in enumerate(raw, 1):
        # An empty line inside a comment is not the end of a block.
        if not line.strip() and not inside:
            documented = own = False
        if line.lstrip().startswith("/**"):
            documented = own = True
        inside = (inside or "/*" in line) and "*/" not in line
        match = None if continued else declared.match(bare[number - 1])
        continued = line.endswith("\\")
        if match:
            checked += 1
            function = bare[number - 1][match.end():].startswith("(") and not line.startswith(("#", "typedef"))
            if not (own if function else documented) and "/*" not in line:
                name = next((group for group in match.groups() if group), match.group())
                complaints.append(f"{path}:{number}: {name} is not documented{' by a comment of its own' if documented else ''}")
            own = False
    return checked, complaints


def main():
    tree = sys.argv[1]
    complaints, checked = [], 0
    for folder, declared in (("include", DECLARED), ("platform", PLATFORM)):
        for path in files(tree, folder, suffixes=(".h",)):
            count, wrong = complaints_of(path, read(tree, path), declared)
            checked += count
            complaints += wrong
    finish(checked, complaints)


main()
