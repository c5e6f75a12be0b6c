# SPDX-License-Identifier: MIT
"""VCD files: a text of signals that change."""
import re


def signals_of(dump):
    """Changes of every signal of a VCD file: {name: [(ns, value)]}."""
    names = dict(re.findall(r"^\$var \w+ \d+ (\S+) (\S+) \$end$", dump, re.M))
    changes = {name: [] for name in names.values()}
    at = 0
    (step, unit) = re.findall(r"\$timescale\s+(\d+)\s*(\w+)\s+\$end", dump)[0]
    for line in dump.partition("$enddefinitions $end\n")[2].split("\n"):
        if line.startswith("#"):
            at = int(line[1:]) * int(step) * {"ns": 1, "us": 1000}[unit]
        elif line.startswith("r"):
            value, name = line[1:].split()
            changes[names[name]].append((at, float(value)))
        elif line and line[0] in "01":
            changes[names[line[1:]]].append((at, int(line[0])))
    return changes
