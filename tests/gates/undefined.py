# SPDX-License-Identifier: MIT
"""The core needs nothing but mem* and the compiler's integer helpers; so it has no float either.
Hardened builds check mem* and the stack on top.

usage: undefined.py NM LIBRARY...
"""

import re
import subprocess
import sys

from sources import finish

ALLOWED = re.compile(
    r"mem(cpy|set|move|cmp)"
    r"|__aeabi_(u?idiv(mod)?|u?ldivmod|lmul|llsl|llsr|lasr|u?lcmp|mem(cpy|set|move|clr)[48]?)"
    r"|__gnu_thumb1_case_\w+"
    r"|__(u?(div|mod|divmod)|mul|ashl|ashr|lshr|clz|ctz|popcount|u?cmp|ffs|bswap)[sd]i[234]?"
    r"|_GLOBAL_OFFSET_TABLE_"
    r"|__stack_chk_fail|__mem(cpy|set|move)_chk"  # of hardened host builds
)


def main():
    nm, *libraries = sys.argv[1:]
    defined, undefined, checked = set(), {}, 0
    for library in libraries:
        lines = subprocess.check_output([nm, "-A", library], text=True).splitlines()
        for line in lines:
            where, kind, name = line.rsplit(maxsplit=2)
            checked += 1
            if kind in "Uvw":
                undefined.setdefault(name, where.split(" ")[0])
            elif kind.isupper():
                defined.add(name)
    finish(
        checked,
        [
            f"{where} needs {name}"
            for name, where in sorted(undefined.items())
            if name not in defined and not ALLOWED.fullmatch(name)
        ],
    )


main()
