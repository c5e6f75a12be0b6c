# SPDX-License-Identifier: MIT
"""The C interface: a page for each public header, made of what Doxygen (its XML) finds in them."""

import re
import subprocess
import sys
import tempfile
import textwrap
import xml.etree.ElementTree as ElementTree
from pathlib import Path

SETTINGS = """
INPUT = {include}/drehgeber
STRIP_FROM_PATH = {include}
OUTPUT_DIRECTORY = {out}
OPTIMIZE_OUTPUT_FOR_C = YES
EXTRACT_ALL = YES
GENERATE_HTML = NO
GENERATE_LATEX = NO
GENERATE_XML = YES
XML_PROGRAMLISTING = NO
INCLUDE_GRAPH = NO
INCLUDED_BY_GRAPH = NO
WARN_IF_INCOMPLETE_DOC = NO
AUTOLINK_SUPPORT = NO
MACRO_EXPANSION = YES
EXPAND_ONLY_PREDEF = YES
PREDEFINED = DG_API=
QUIET = YES
WARN_IF_UNDOCUMENTED = NO
"""
SECTIONS = {"define": "Macros", "enum": "Enumerations", "typedef": "Types", "struct": "Structures",
            "func": "Functions", "var": "Objects"}
# Guards, and what only joins tokens, are nobody's business.
HIDDEN = re.compile(r"DREHGEBER_\w+_H$")


def _escape(text: str) -> str:
    return re.sub(r"([*_<>|\[\]`\\])", r"\\\1", text)


def _code(text: str) -> str:
    return f"`{' '.join(text.split())}`" if text.strip() else ""


def _inline(node) -> str:
    """A paragraph, without what stands in a paragraph of its own."""
    parts = [_escape(node.text or "")]
    for child in node:
        if child.tag in ("computeroutput", "ref"):
            parts.append(_code("".join(child.itertext())))
        elif child.tag not in ("simplesect", "parameterlist", "verbatim", "itemizedlist", "programlisting"):
            parts.append(_inline(child))
        parts.append(_escape(child.tail or ""))
    return " ".join("".join(parts).split())


def _blocks(node):
    """Paragraphs, lists, drawings and returns of a description, as Markdown."""
    for child in node:
        if child.tag == "para":
            text = _inline(child)
            if text:
                yield text
            yield from _blocks(child)
        elif child.tag in ("verbatim", "programlisting", "preformatted"):
            yield "```\n" + "".join(child.itertext()).strip("\n") + "\n```"
        elif child.tag == "itemizedlist":
            yield "\n".join("- " + " ".join(_blocks(item)) for item in child)
        elif child.tag == "simplesect":
            word = {"return": "Returns", "note": "Note", "see": "See"}.get(child.get("kind"), child.get("kind"))
            yield f"*{word}:* " + " ".join(_blocks(child))
        elif child.tag == "parameterlist":
            yield "\n".join(f"- {_code(''.join(item.find('parameternamelist').itertext()))}: "
                            + " ".join(_blocks(item.find("parameterdescription"))) for item in child)


def _told(member) -> list:
    return [block for tag in ("briefdescription", "detaileddescription")
            for block in _blocks(member.find(tag))]


def _in_a_row(member) -> str:
    found = member.find("inbodydescription")
    more = list(_blocks(found)) if found is not None else []
    return " ".join(_told(member) + more).replace("\n", " ")


def _declaration(member) -> str:
    """As the header has it."""
    kind, name = member.get("kind"), member.findtext("name")
    if kind == "define":
        arguments = [item.findtext("defname") or "" for item in member.findall("param")]
        value = "".join(member.find("initializer").itertext()) if member.find("initializer") is not None else ""
        return f"#define {name}{'(' + ', '.join(arguments) + ')' if arguments else ''} {value}".strip()
    if kind == "enum":
        return f"enum {name}" if name else "enum"
    return f"{member.findtext('definition')}{member.findtext('argsstring') or ''}"


def _rows(title: str, rows) -> list:
    rows = list(rows)
    return [f"| {title} | |\n|---|---|\n" + "\n".join(f"| {_code(a)} | {b} |" for a, b in rows)] if rows else []


def _member(member) -> list:
    name = member.findtext("name")
    out = [f"### {name or 'without a name'} {{ #{name or member.get('id')} }}", f"```c\n{_declaration(member)}\n```"]
    out += _told(member)
    if member.get("kind") == "enum":
        out += _rows("value", ((f"{value.findtext('name')} {value.findtext('initializer') or ''}", _in_a_row(value))
                               for value in member.findall("enumvalue")))
    return out


def _struct(xml: Path, reference: str) -> list:
    compound = ElementTree.parse(xml / f"{reference}.xml").getroot().find("compounddef")
    name = compound.findtext("compoundname")
    if "." in name or "@" in name:  # what stands inside of another one
        return []
    members = compound.iter("memberdef")
    return [f"### {compound.get('kind')} {name} {{ #{name} }}"] + _told(compound) + \
        _rows("member", ((f"{member.findtext('definition').replace(name + '::', '')}{member.findtext('argsstring') or ''}",
                          _in_a_row(member)) for member in members))


def _about(text: str):
    """The comment at the top of a header as it stands: what is indented in it is a drawing or code."""
    comment = re.search(r"/\*\*\n \* @file\n(.*?)\*/", text, re.S)[1]
    for block in re.sub(r"^ \*(?: |$)", "", comment, flags=re.M).strip("\n ").split("\n\n"):
        drawn = all(line.startswith("  ") or not line for line in block.split("\n"))
        if drawn:
            yield "```\n" + textwrap.dedent(block) + "\n```"
        else:
            parts = re.split(r"(`[^`]*`)", block)
            yield "".join(part if part.startswith("`") else _escape(part) for part in parts)


def _page(tree: Path, xml: Path, compound) -> str:
    header = compound.findtext("compoundname")
    parts = {section: [] for section in SECTIONS}
    for section in compound.iter("sectiondef"):
        for member in section.findall("memberdef"):
            kind = {"function": "func", "variable": "var"}.get(member.get("kind"), member.get("kind"))
            if not HIDDEN.match(member.findtext("name") or ""):
                parts[kind] += _member(member)
    for inner in compound.findall("innerclass"):
        parts["struct"] += _struct(xml, inner.get("refid"))
    out = [f"# drehgeber/{header}", f"```c\n#include <drehgeber/{header}>\n```"]
    out += _about((tree / "include/drehgeber" / header).read_text(encoding="utf-8"))
    for section, title in SECTIONS.items():
        out += [f"## {title}"] + parts[section] if parts[section] else []
    return "\n\n".join(out) + "\n"


def pages(tree: Path) -> dict:
    """Path of a page: its text; one for every header."""
    with tempfile.TemporaryDirectory() as out:
        settings = SETTINGS.format(include=tree / "include", out=out)
        done = subprocess.run(["doxygen", "-"], input=settings, text=True, capture_output=True, timeout=120, check=True)
        if done.stderr:
            sys.exit(f"doxygen:\n{done.stderr}")
        xml = Path(out) / "xml"
        compounds = [ElementTree.parse(path).getroot().find("compounddef") for path in sorted(xml.glob("*_8h.xml"))]
        return {f"docs/c/{compound.findtext('compoundname')}.md": _page(tree, xml, compound) for compound in compounds}
