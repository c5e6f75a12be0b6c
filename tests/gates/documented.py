# SPDX-License-Identifier: MIT
"""Every public prototype and variable is documented: a comment opens the block of lines it stands
in. A block ends at an empty line, so that one comment can speak for several similar functions.

usage: documented.py TREE
"""

import re
import sys

from sources import blank, files, finish, read

DECLARED = re.compile(r"^(?!\s|#|typedef|struct \w+(?: \{|;)|enum)[\w \*]*\b(dg_\w+)(\(|\[|;)")


def main():
    tree = sys.argv[1]
    complaints, checked = [], 0
    for path in files(tree, "include", suffixes=(".h",)):
        text = read(tree, path)
        raw, bare = text.split("\n"), blank(text).split("\n")
        documented, inside = False, False
        for number, line in enumerate(raw, 1):
            # An empty line inside a comment is not the end of a block.
            if not line.strip() and not inside:
                documented = False
            if line.lstrip().startswith("/**"):
                documented = True
            inside = (inside or "/*" in line) and "*/" not in line
            match = DECLARED.match(bare[number - 1])
            if match:
                checked += 1
                if not documented:
                    complaints.append(f"{path}:{number}: {match.group(1)} is not documented")
    finish(checked, complaints)


main()
