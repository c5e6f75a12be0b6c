# SPDX-License-Identifier: MIT
"""Starts the installed unit's service as systemd does, without systemd: what ExecStart= says, as a user without rights,
with folders of its own, until it says READY=1. Then turns its shaft to POSITION, asks where it is, and ends it.

usage: service.py POSITION
"""

import configparser
import os
import shlex
import socket
import subprocess
import sys
from pathlib import Path

UNIT = Path("/lib/systemd/system/drehgeber@.service")
RIG = "[rig]\nname = bench\n[encoder feedback]\nmodel = s3684-rs485\nwire = pty\nnvm = /var/lib/drehgeber/bench/feedback.nvm\n"
NAME, USER, PATIENCE_S = "bench", 65534, 30
ROOTS = {"%i": NAME, "%S": "/var/lib"}


def setting(section, key):
    text = section[key]
    for short, means in ROOTS.items():
        text = text.replace(short, means)
    return text


def make_folder(path, mode):
    path.mkdir(parents=True)
    path.chmod(int(mode, 8))
    os.chown(path, USER, USER)
    return path


def main():
    unit = configparser.ConfigParser(strict=False, interpolation=None, comment_prefixes=("#",))
    unit.optionxform = str
    unit.read(UNIT, encoding="utf-8")
    service = unit["Service"]
    Path(f"/etc/drehgeber/{NAME}.ini").write_text(RIG, encoding="utf-8")
    runtime, state = (make_folder(Path(root, setting(service, f"{kind}Directory")), service[f"{kind}DirectoryMode"])
                      for root, kind in (("/run", "Runtime"), ("/var/lib", "State")))
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as notified:
        notified.bind("/tmp/notify")
        os.chmod("/tmp/notify", 0o777)
        notified.settimeout(PATIENCE_S)
        variables = {"RUNTIME_DIRECTORY": str(runtime), "STATE_DIRECTORY": str(state), "NOTIFY_SOCKET": "/tmp/notify"}
        with subprocess.Popen(shlex.split(setting(service, "ExecStart")), cwd=setting(service, "WorkingDirectory"), user=USER,
                              group=USER, umask=int(service["UMask"], 8), env={"PATH": os.environ["PATH"], **variables}) as running:
            try:
                said = ""
                while "READY=1" not in said:
                    said = notified.recv(4096).decode()
                print("READY=1", flush=True)
                control = ["drehgeber", "ctl", "--control", f"unix:{next(runtime.glob('*.sock'))}"]
                subprocess.run([*control, f"SHAF:POS {sys.argv[1]}", "SHAF:POS?"], check=True, timeout=PATIENCE_S)
            finally:
                running.terminate()
    assert running.returncode == 0, running.returncode
    assert (state / "feedback.nvm").stat().st_size > 0


main()
