# SPDX-License-Identifier: MIT
"""Manual pages and completion, as man, bash and zsh take them."""
import json
import os
import re
import subprocess
import time

import pytest

from rig import MULTITURN, PATIENCE_S, PROGRAM, REPOSITORY, run

MAN = REPOSITORY / "tools/man"
COMPLETION = REPOSITORY / "tools/completion"
COMMANDS = ["list", "faults", "run", "eds", "check", "model", "biss", "ssi", "map", "fmu", "verify", "ctl", "top", "web",
            "explain", "help"]
PAGES = ["drehgeber.1", *(f"drehgeber-{command}.1" for command in COMMANDS)]


def rendered(page):
    """The text of a page; man must have nothing to say about it."""
    ended = subprocess.run(
        ["man", "--warnings=w", "-E", "UTF-8", "-l", str(MAN / page)], text=True, timeout=PATIENCE_S,
        env={**os.environ, "MANWIDTH": "80", "LC_ALL": "C.UTF-8", "MANROFFOPT": "", "MAN_KEEP_FORMATTING": ""},
        capture_output=True, check=True)
    assert ended.stderr == ""
    return re.sub(r".\x08", "", ended.stdout)


@pytest.mark.parametrize("page", PAGES)
def test_a_page_renders(page):
    text = rendered(page)
    for title in "NAME", "SYNOPSIS", "DESCRIPTION", "OPTIONS", "EXIT STATUS", "SEE ALSO":
        assert re.search(f"^{title}$", text, re.M), title
    assert max(len(line) for line in text.splitlines()) <= 80


def test_there_is_a_page_for_each_command():
    said = run("--help").stdout
    assert {found for found in re.findall(r"^  drehgeber (\w+)", said, re.M)} == set(COMMANDS)
    assert sorted(path.name for path in MAN.iterdir()) == sorted(PAGES)


def test_a_page_has_what_help_has():
    """Options, settings and models: the same, however they are broken into lines."""
    text = " ".join(rendered("drehgeber-run.1").replace("‐\n", "").split())
    said = run("run", "--help").stdout + run("--help").stdout
    options = set(re.findall(r"--[a-z]+(?:\[=\w+\]|=\S+)?(?=  )", said))
    assert len(options) > 15
    for option in options - {"--json", "--explain", "--output=FILE", "--fmi=VERSION", "--listen=HOST:PORT", "--token=FILE", "--watch",
                             "--timeout=SPAN", "--against=MODEL", "--address=N", "--alone", "--junit=FILE", "--report=FILE",
                             "--write", "--irreversible", "--restore", "--journal=FILE", "--power=COMMAND"}:
        assert option in text, option
    keys = set(re.findall(r"^  ([a-z]+_[a-z_]+)  ", said, re.M))
    assert len(keys) > 20
    for key in keys:
        assert re.search(rf" {key} ", text), key
    for row in json.loads(run("list", "--json").stdout):
        assert "file" in row or row["model"] in text


BASH = """
. /usr/share/bash-completion/bash_completion
. {script}
COMP_LINE={line!r} COMP_POINT=${{#COMP_LINE}} COMP_TYPE=9
COMP_WORDS=({words}) COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1))
_drehgeber 2>{errors}
printf '%s\\n' "${{COMPREPLY[@]}}"
"""


def bash(line, folder):
    """What bash completes a line with, split into words as readline does."""
    words = re.findall(r"[=:]|[^\s=:]+", line) + ([""] if line[-1] in " =:" else [])
    script = BASH.format(script=COMPLETION / "drehgeber.bash", line=line, errors=folder / "errors",
                         words=" ".join(f"'{word}'" for word in words))
    ended = subprocess.run(["bash", "--norc", "-c", script], text=True, capture_output=True, cwd=folder,
                           timeout=PATIENCE_S, check=True)
    wrong = [line for line in (folder / "errors").read_text().splitlines() if "compopt" not in line]
    assert (ended.stderr, wrong) == ("", [])
    return [line for line in ended.stdout.split("\n") if line]


@pytest.mark.parametrize("line, wanted, unwanted", [
    ("drehgeber ", COMMANDS, []),
    ("drehgeber f", ["faults"], ["list"]),
    ("drehgeber help e", ["eds"], []),
    ("drehgeber run s3", [MULTITURN, "s3674-biss"], ["f3668"]),
    ("drehgeber run ", [MULTITURN, "bench.ini", "sub"], ["other.txt"]),
    ("drehgeber eds ", ["f3658", "f3668"], [MULTITURN]),
    ("drehgeber map ", ["ocd-ib-k3"], [MULTITURN]),
    ("drehgeber biss s3674-biss ", ["read", "registers", "eds", "write", "command"], []),
    ("drehgeber biss s3674-biss --", ["--shaft=", "--help"], ["--can=", "--json"]),
    ("drehgeber run s3684-rs485 --p", ["--pty="], ["--tty="]),
    ("drehgeber run s3684-rs485 --pty --set ", ["pace=", "temperature=", "turns="], ["stop_bit="]),
    ("drehgeber run s3684-biss --set=", ["stop_bit=", "clock_hz="], ["pace="]),
    ("drehgeber run s3684-rs485 --nvm o", ["other.txt"], ["bench.ini"]),
    ("drehgeber run s3684-rs485 --files ", ["sub"], ["other.txt"]),
    ("drehgeber run s3684-rs485 --shaft ", ["60RPM", "90DEG"], []),
    ("drehgeber map --ring ocd-ib-k", ["ocd-ib-k1", "ocd-ib-k2"], []),
    ("drehgeber top ", ["unix:"], []),
    ("drehgeber explain o", ["other.txt"], ["ocd-ib-k1"]),
    ("drehgeber explain other.txt --against f", ["f3658", "f3668"], []),
    ("drehgeber --", ["--help", "--version"], []),
    ("drehgeber list --", ["--json", "--help"], ["--pty="]),
])
def test_bash(tmp_path, line, wanted, unwanted):
    (tmp_path / "here/sub").mkdir(parents=True)
    for name in ("bench.ini", "other.txt"):
        (tmp_path / "here" / name).touch()
    (tmp_path / "here/errors").touch()
    found = bash(line, tmp_path / "here")
    assert set(wanted) <= set(found) and not set(unwanted) & set(found), found


class Zsh:
    """A zsh in a terminal of tmux, with nothing but the completion."""

    def __init__(self, folder):
        self.name = f"drehgeber-zsh-{os.getpid()}"
        (folder / ".zshrc").write_text(
            f"fpath=({COMPLETION} $fpath)\nautoload -U compinit\ncompinit -u -D\nPS1='% '\nunsetopt LIST_AMBIGUOUS\n"
            f"alias drehgeber={PROGRAM}\nzstyle ':completion:*' list-prompt ''\n"
            f"LISTMAX=1000\ncompdef _drehgeber {PROGRAM}\n")
        self.environment = {**os.environ, "ZDOTDIR": str(folder)}
        self.tmux("new-session", "-d", "-x", "150", "-y", "50", f"cd {folder} && exec zsh -i")

    def tmux(self, *arguments):
        return subprocess.run(["tmux", "-f", "/dev/null", "-L", self.name, *arguments], text=True, check=True,
                              env=self.environment, stdout=subprocess.PIPE, timeout=PATIENCE_S).stdout

        deadline = time.monotonic() + PATIENCE_S
        while not self.tmux("capture-pane", "-p").startswith("% "):
            assert time.monotonic() < deadline
            time.sleep(0.05)

    def completes(self, line, *wanted):
        self.tmux("send-keys", "C-u")
        self.tmux("send-keys", "C-l")
        self.tmux("send-keys", "-l", line)
        self.tmux("send-keys", "Tab")
        deadline = time.monotonic() + PATIENCE_S
        while True:
            screen = self.tmux("capture-pane", "-p")
            if all(re.search(rf"(?<!\S){re.escape(word)}", screen) for word in wanted):
                return screen
            assert time.monotonic() < deadline, (wanted, screen)
            time.sleep(0.05)


def test_zsh(tmp_path):
    zsh = Zsh(tmp_path)
    try:
        screen = zsh.completes("drehgeber ", *COMMANDS)
        assert "-- print the models" in screen
        zsh.completes("drehgeber fau", "drehgeber faults")
        assert "s3674" not in zsh.completes("drehgeber eds ", "f3658", "f3668")
        zsh.completes("drehgeber run s3684-r", f"drehgeber run {MULTITURN}")
        zsh.completes("drehgeber biss s3674-biss ", "read", "registers", "command")
        screen = zsh.completes(f"drehgeber run {MULTITURN} --s", "--shaft", "--slcan", "--serial")
        assert "how the shaft moves" in screen
        zsh.completes("drehgeber run s3684-biss --set stop", "stop_bit=")
    finally:
        subprocess.run(["tmux", "-L", zsh.name, "kill-server"], check=False, timeout=PATIENCE_S)
