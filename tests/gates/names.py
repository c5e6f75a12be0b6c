# SPDX-License-Identifier: MIT
"""A function is verb and object. A static function whose name another file has, too, lacks an object; few may. What a file calls
its operations of a seam (`.step = step`), and what a macro of a header calls, is exempt: these are alike on purpose.

usage: names.py TREE
"""

import re
import sys
from collections import defaultdict

from sources import blank, files, finish, read

FOLDERS = ("src", "platform", "tools")
FILES_MAX = 3
SHARED_PERCENT = 10
BARE = set("""
    acknowledge act add align allocate answer append apply arm arrive ask attach attempt await become begin bend build
    call check clock collect compare complain complete conclude configure copy corrupt create cut deliver describe
    detach differ discard divide drain draw drop emit end enter erase escape evaluate exchange execute explain extend
    fail feed fetch fill find finish fit flip flush follow forget format gather greet grow happen hear hold initialise
    instruct issue join judge latch leave listen load lock look make mark measure merge mind mix modify mount multiply
    negate negotiate notice offer pack parse pass place play poll pop power press print program push put queue reach
    receive refuse release remember replace replay report request reset resize resolve rest reverse run sample
    saturate say select send serve set settle share shift shut skip split spread start step stir stop store straighten
    subtract succeed sweep synchronise take tear tell transfer transmit trim tune turn unbend understand unload
    unquote unwatch upload use wake warn watch welcome wrap
""".split())
STATIC = re.compile(r"^static\s[^;={}()]*?\b(\w+)\((?:[^;{}()]|\([^;{}()]*\))*\)\s*\{", re.M)
OPERATION = re.compile(r"\.\w+\s*=\s*&?(\w+)\b(?!\s*\()")
MACRO = re.compile(r"^[ \t]*#[ \t]*define\b(?:[^\n]*\\\n)*[^\n]*", re.M)
LISTED = re.compile(r"[{,]\s*(\w+)\s*(?=[,}])")


def functions(tree):
    """File, name and line of each static function that is no operation."""
    headers = "\n".join(blank(read(tree, path)) for path in files(tree, "include", *FOLDERS, suffixes=(".h",)))
    common = set(OPERATION.findall(headers))
    for macro in MACRO.findall(headers):
        common |= set(re.findall(r"\b(\w+)\(", macro))
    for path in files(tree, *FOLDERS, suffixes=(".c",)):
        text = blank(read(tree, path))
        own = set(OPERATION.findall(text)) | set(LISTED.findall(text))
        for found in STATIC.finditer(text):
            if found[1] not in common | own:
                yield path, found[1], text.count("\n", 0, found.start(1)) + 1


def main():
    tree = sys.argv[1]
    places = defaultdict(dict)
    for path, name, line in functions(tree):
        places[name][path] = line
    count = sum(map(len, places.values()))
    complaints = [f"{path}:{line}: {name}() names no object" for name, at in sorted(places.items()) if name in BARE
                  for path, line in at.items()]
    complaints += [f"{name}() is in {len(at)} files, at most {FILES_MAX}: {' '.join(at)}" for name, at in sorted(places.items())
                   if len(at) > FILES_MAX]
    shared = sum(len(at) for at in places.values() if len(at) > 1)
    print(f"{shared} of {count} static functions have a name that another file has, too")
    if 100 * shared > SHARED_PERCENT * count:
        worst = sorted((name for name, at in places.items() if len(at) > 1), key=lambda name: -len(places[name]))
        complaints.append(f"that is {100 * shared / count:.1f} %, at most {SHARED_PERCENT}: {' '.join(worst)}")
    finish(len(files(tree, *FOLDERS, suffixes=(".c",))), complaints)


main()
