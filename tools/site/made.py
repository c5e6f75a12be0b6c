# SPDX-License-Identifier: MIT
"""What pages show that nobody has typed: `<!-- made: NAME WORDS -->` in a page becomes what NAME makes.

Pictures are of the program $DREHGEBER, run now; figures are of the results that tools/check has left in the folder
$DREHGEBER_LOG. What has not been run there is said so."""

import base64
import html
import json
import os
import re
import subprocess
import tempfile
import time
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import overview
import waveform

PATIENCE_S = 60
TREE = Path(__file__).resolve().parents[2]
PROGRAM = os.path.realpath(os.environ["DREHGEBER"])
LOG = Path(os.environ.get("DREHGEBER_LOG", TREE / "build/log"))
NOT_RUN = "not in this run"
RIG = """[rig]
name = bench
control = unix:panel.sock
[shaft motor]
motion = 60RPM
[shaft wheel]
driver = motor
ratio = 1:10
[encoder feedback]
model = s3684-rs485
wire = pty
[encoder load]
model = f3668
wire = slcan
[encoder wheel]
model = s3684-biss
shaft = wheel
wire = sim
[encoder ring]
model = ocd-ib-k3
wire = modbus:127.0.0.1:0
"""
# What a master sends to node 63 over SLCAN: device type, position, a preset, position; operational; SYNC.
CAN = ("t63F84000100000000000", "t63F84004600000000000", "t63F8230360000A000000", "t63F84004600000000000",
       "t0002013F", "t0800")


def _run(*command, **options) -> str:
    return subprocess.run(command, text=True, capture_output=True, timeout=PATIENCE_S, check=True, **options).stdout


class _Running:
    """The program as long as the context lasts, once it is ready."""

    def __init__(self, *arguments, folder: str):
        self.process = subprocess.Popen([PROGRAM, "run", *arguments], cwd=folder, stdout=subprocess.PIPE, text=True)
        os.set_blocking(self.process.stdout.fileno(), True)

    def __enter__(self):
        for line in self.process.stdout:
            if line.startswith("control "):
                return self
        raise RuntimeError(f"{PROGRAM} has ended with {self.process.wait()}")

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait(PATIENCE_S)
        self.process.stdout.close()


def _figure(picture: str, caption: str) -> str:
    return f'<figure style="width:100%">{picture}<figcaption>{caption}</figcaption></figure>'


def _biss_lines(address: str, count: str) -> dict:
    """MA and SLO of a register access."""
    with tempfile.TemporaryDirectory() as folder:
        _run(PROGRAM, "biss", "s3684-biss", "read", "registers", address, count, "--shaft", "90DEG", "--trace", "biss.vcd",
             cwd=folder)
        return waveform.read((Path(folder) / "biss.vcd").read_text(encoding="utf-8"))


def _biss_access(address: str, count: str) -> str:
    """Both pictures, and the registers as the levels have them."""
    lines = _biss_lines(address, count)
    _, asked, answered = waveform.access_of(waveform.frames(lines), int(count))
    at = next(waveform.number(bits) for name, _, bits in asked if name == "ADR")
    data = [f"{waveform.number(bits):02X}" for name, _, bits in answered if name == "DATA"]
    return "\n\n".join((
        _figure(waveform.frame_picture(lines), "One frame, as the master sees the two lines"),
        _figure(waveform.access_picture(lines, int(count)),
                f"{len(waveform.frames(lines))} frames, a bit in each: register {at:02X}h is asked for on CDM, "
                f"{' '.join(data)} comes back on CDS")))


# The tools of the window's upper part, and no list of files at its left.
GTKWAVE = ("gtkwave", "--nomenu", *(word for setting in ("splash_disable on", "hide_sst on", "initial_window_x 1200",
                                                         "initial_window_y 220") for word in ("--rcvar", setting)))


def _gtkwave() -> str:
    """The end of a register access in GTKWave, on a screen that nobody sees."""
    with tempfile.TemporaryDirectory() as folder:
        _run(PROGRAM, "biss", "s3684-biss", "read", "registers", "0x78", "4", "read", "--shaft", "90DEG", "--trace",
             "biss.vcd", cwd=folder)
        trace = (Path(folder) / "biss.vcd").read_text(encoding="utf-8")
        told = re.findall(r"^#(\d+)\n(?:[01].*\n)*sregister_", trace, re.M)[0]
        at_us = int(told) * waveform.STEP_NS // 1000
        (Path(folder) / "grab.tcl").write_text(f"gtkwave::setZoomRangeTimes {at_us - 144}us {at_us + 66}us\n"
                                               "gtkwave::/File/Grab_To_File wave.png\ngtkwave::/File/Quit\n")
        _run("xvfb-run", "--auto-servernum", "--server-args=-screen 0 1200x220x24", *GTKWAVE, "--script", "grab.tcl",
             "biss.vcd", TREE / "tools/gtkwave/biss.gtkw", cwd=folder)
        picture = (Path(folder) / "wave.png").read_bytes()
    return _figure(f'<img alt="MA, SLO and text in GTKWave" src="data:image/png;base64,{base64.b64encode(picture).decode()}">',
                   "GTKWave behind the last bit of the access: the text says what was read")


class _Terminal:
    """A terminal of tmux in which top runs."""

    def __init__(self, folder: str):
        self.name, self.folder = f"drehgeber-site-{os.getpid()}", folder
        # Whoever has tmux around this keeps it out of here; the size is the terminal's, whatever pytest says.
        self.environment = {key: value for key, value in os.environ.items() if not key.startswith(("TMUX", "COLUMNS", "LINES"))}

    def tmux(self, *arguments: str) -> str:
        return _run("tmux", "-f", "/dev/null", "-L", self.name, *arguments, cwd=self.folder,
                    env=self.environment | {"LC_ALL": "C.UTF-8"})

    def __enter__(self):
        self.tmux("new-session", "-d", "-x", "100", "-y", "26", f"{PROGRAM} top unix:panel.sock")
        return self

    def __exit__(self, *_):
        self.tmux("kill-server")

    def wait(self, wanted: str) -> str:
        """The screen, as soon as this is on it."""
        deadline = time.monotonic() + PATIENCE_S
        while not re.search(wanted, screen := self.tmux("capture-pane", "-p"), re.S):
            if time.monotonic() > deadline:
                raise RuntimeError(f"top does not show {wanted}:\n{screen}")
            time.sleep(0.1)
        return screen


def top() -> str:
    """A rig, and what top shows of it at some moment, so that it is another picture each time."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "bench.ini").write_text(RIG, encoding="utf-8")
        with _Running("bench.ini", folder=folder), _Terminal(folder) as terminal:
            terminal.wait(" 1/4  feedback ")
            terminal.tmux("send-keys", "Down", "Down")
            screen = terminal.wait(r" 3/4  wheel .*last frames.*position")
    rows = [row.rstrip() for row in screen.split("\n")]
    return "\n".join(row for row in rows if row) + "\n"


def _wireshark() -> str:
    """A master's first steps with an F3668, as Wireshark reads the trace."""
    with tempfile.TemporaryDirectory() as folder:
        with _Running("f3668", "--slcan=can", "--shaft", "90DEG", "--trace", "can.pcapng", "--control",
                      "unix:panel.sock", folder=folder):
            port = os.open(Path(folder) / "can", os.O_RDWR | os.O_NOCTTY)
            for line in ("O", *CAN):
                os.write(port, line.encode() + b"\r")
                time.sleep(0.05)
            os.close(port)
        rows = _run("tshark", "-r", f"{folder}/can.pcapng", "-d", "can.subdissector,canopen")
        one = _run("tshark", "-r", f"{folder}/can.pcapng", "-d", "can.subdissector,canopen", "-O", "canopen", "-Y",
                   "canopen.sdo.main_idx == 0x6004")
    # Number, moment and what it is: the moment is of this machine and this run.
    rows = "\n".join(" ".join(words[:1] + words[2:]) for words in map(str.split, rows.split("\n"))).strip()
    return f"```text\n{rows}\n```\n\nOne of them, unfolded:\n\n```text\n{one.strip().split(chr(10) * 2)[1]}\n```"


def _faults(model: str) -> str:
    """What can happen to a model, and what it does about it."""
    rows = json.loads(_run(PROGRAM, "faults", model, "--json"))
    lines = [f"| `{row['name']}` | {html.escape(row['cause'])} | {html.escape(row['effect'])} | {row['chapter']} |"
             for row in rows]
    return "| fault | cause | what the encoder does | manual |\n|---|---|---|---|\n" + "\n".join(lines)


def _playground() -> str:
    """Where it is in the site; the page that says this is a folder's."""
    return "**[Open it](../../playground/index.html)**, or take [the one file](../../playground/drehgeber.html)."


def _try() -> str:
    """The playground in the first page, and where it is alone."""
    return ('<div class="try"><iframe src="playground/drehgeber.html" title="Playground: four encoders on one shaft"></iframe></div>\n\n'
            "**[Open the playground in its own page](playground/index.html)**, with everything that an encoder has.")


def _results(tree: str) -> dict:
    """Output of each test of a tree as tools/check has run it; none when it has not."""
    try:
        root = ElementTree.parse(LOG / f"{tree}.xml").getroot()
    except (OSError, ElementTree.ParseError):
        return {}
    return {case.get("name"): (case.get("status"), case.findtext("system-out") or "") for case in root.iter("testcase")}


def _found(results: dict, test: str, pattern: str) -> tuple:
    """What the groups of a pattern are in a test's output."""
    match = re.search(pattern, results.get(test, ("", ""))[1])
    return match.groups() if match else ()


def _thousands(number: str) -> str:
    return f"{int(number):,}".replace(",", " ")


def _conformance() -> str:
    """Clauses of the manuals, and what proves them."""
    results, rows = _results("release"), []
    for path in sorted((TREE / "tests/conformance").glob("*.clauses")):
        if "selftest" in path.name:
            continue
        found = _found(results, f"conformance.{path.stem}",
                       r"all +(\d+) of (\d+) clauses, (\d+) rows; (\d+) clauses do not hold")
        rows.append(f"| `{path.stem}` | " + (" | ".join(found) if found else f"{NOT_RUN} | | | ") + " |")
    return "| | clauses proven | of | rows | listed as not held |\n|---|---|---|---|---|\n" + "\n".join(rows)


def _fuzzing() -> str:
    """Inputs, executions and edges of each target."""
    results, rows = _results("fuzz"), []
    for name in sorted(path.stem for path in (TREE / "tests/fuzz").glob("fuzz_*.c")):
        found = next((match.groups() for _, output in results.values()
                      if (match := re.search(rf"{name}: (\d+) inputs, (\d+) new executions .*?, (\d+) edges", output))),
                     ())
        rows.append(f"| `{name.removeprefix('fuzz_')}` | "
                    + (" | ".join(map(_thousands, found)) if found else f"{NOT_RUN} | | ") + " |")
    return "| target | inputs kept | new executions | edges |\n|---|---|---|---|\n" + "\n".join(rows)


def _trees() -> str:
    """Tests of each tree, by what became of them."""
    rows = []
    for path in sorted(LOG.glob("*.xml")):
        if not path.name.startswith("again-"):
            states = [status for status, _ in _results(path.stem).values()]
            rows.append(f"| `{path.stem}` | {states.count('run')} | {len(states)} |")
    return "| tree | passed at the first try | tests |\n|---|---|---|\n" + "\n".join(rows or [f"| {NOT_RUN} | | |"])


def _mutation() -> str:
    found = next((match.groups() for _, output in _results("mutation").values()
                  if (match := re.search(r"mutation score of src: (\S+) %, (\d+) of the last (\d+) killed", output))), ())
    return f"**{found[0]} %**: {found[1]} of {found[2]} mutants were noticed." if found else f"The score is {NOT_RUN}."


def _power() -> str:
    found = _found(_results("release"), "power.loss", r"power loss: (\d+) states, (\d+) of them inside a recovery")
    if not found:
        return f"The number of states is {NOT_RUN}."
    return f"**{_thousands(found[0])} states**, {_thousands(found[1])} of them inside a recovery; no promise was broken."


def _headers() -> str:
    rows = []
    for path in sorted((TREE / "include/drehgeber").glob("*.h")):
        text = path.read_text(encoding="utf-8")
        first = re.search(r"@file\n \* (.*?)[.:;](?:\s|\*)", text, re.S)
        about = " ".join(first[1].replace("\n *", " ").split()) if first else ""
        rows.append(f"| [{path.name}](c/{path.name}.md) | {about} |")
    return "| header | what |\n|---|---|\n" + "\n".join(rows)


def _images(group: str, figures: dict[str, str]) -> list[str]:
    """A row for each image of a processor. Only images of a core alone have their RAM among the figures."""
    ram = {name: _thousands(value) for name, value in figures.items() if name.endswith(".ram")}
    return [f"| {group} | `{name.removesuffix('.flash')}` | {_thousands(flash)} | "
            f"{ram.get(name.replace('.flash', '.ram'), '')} |"
            for name, flash in figures.items() if name.endswith(".flash")]


def _sizes() -> str:
    """Flash and RAM of whole images, as they were measured."""
    rows = []
    for path in sorted(LOG.parent.glob("size*/tests/bench/*.figures")):
        group, *lines = path.read_text(encoding="utf-8").split("\n")
        rows += _images(group, dict(line.split()[:2] for line in lines if line))
    return "| processor | image | flash | RAM |\n|---|---|---|---|\n" + "\n".join(rows or [f"| {NOT_RUN} | | | |"])


def _tests(*beginnings: str) -> str:
    """Tests of the release tree with such names, and what became of them."""
    rows = [f"| `{name}` | {'passed' if status == 'run' else status} |"
            for name, (status, _) in sorted(_results("release").items()) if name.startswith(beginnings)]
    return "| test | |\n|---|---|\n" + "\n".join(rows or [f"| {NOT_RUN} | |"])


MAKERS = {
    "biss-access": _biss_access, "gtkwave": _gtkwave, "wireshark": _wireshark, "faults": _faults, "trees": _trees,
    "conformance": _conformance, "fuzzing": _fuzzing, "mutation": _mutation, "power": _power, "headers": _headers,
    "sizes": _sizes, "tests": _tests, "playground": _playground, "try": _try,
}


def make(name: str, words: list) -> str:
    return MAKERS[name](*words)


# Pictures that are in the tree, for readers of the pages as they are.
PICTURES = {
    "docs/biss.svg": lambda: waveform.alone(waveform.frame_picture(_biss_lines("0x78", "4"))),
    "docs/drehgeber.svg": lambda: overview.picture(PROGRAM),
}
# The screen of top is in a page, between marks.
SCREEN_PAGE = TREE / "docs/traces.md"
SCREEN = re.compile(r"(?<=<!-- screen -->\n```\n).*?(?=```\n<!-- end -->)", re.S)


if __name__ == "__main__":
    for path, picture in PICTURES.items():
        (TREE / path).write_text(picture(), encoding="utf-8")
    SCREEN_PAGE.write_text(SCREEN.sub(lambda _: top(), SCREEN_PAGE.read_text(encoding="utf-8")), encoding="utf-8")
