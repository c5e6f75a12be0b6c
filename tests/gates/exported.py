# SPDX-License-Identifier: MIT
"""Every symbol a library exports starts with dg_.

usage: exported.py LIBRARY...
"""

import subprocess
import sys

from sources import finish


def main():
    complaints, checked = [], 0
    for library in sys.argv[1:]:
        dynamic = ["-D"] if ".so" in library else []
        command = ["nm", *dynamic, "--extern-only", "--defined-only", "--format=posix", library]
        names = [
            line.split()[0]
            for line in subprocess.check_output(command, text=True).splitlines()
            if line and not line.endswith(":")
        ]
        if not names:
            complaints.append(f"{library} exports nothing")
        checked += len(names)
        complaints += [f"{library} exports {name}" for name in names if not name.startswith("dg_")]
    finish(checked, complaints)


main()
