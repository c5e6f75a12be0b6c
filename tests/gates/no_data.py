# SPDX-License-Identifier: MIT
"""No object of the core has data or bss: there are no mutable variables outside the caller's.

usage: no_data.py SIZE LIBRARY...
"""

import subprocess
import sys

from sources import finish


def main():
    size, *libraries = sys.argv[1:]
    complaints, checked = [], 0
    for library in libraries:
        for line in subprocess.check_output([size, library], text=True).splitlines()[1:]:
            _text, data, bss, _dec, _hex, name = line.split(maxsplit=5)
            checked += 1
            if int(data) + int(bss):
                complaints.append(f"{name}: {data} bytes of data, {bss} bytes of bss")
    finish(checked, complaints)


main()
