# SPDX-License-Identifier: MIT
"""Fresh roots of a Debian, made by debootstrap, and commands in them. Needs root and the network."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

MIRROR = "http://deb.debian.org/debian"
ENVIRONMENT = {"PATH": "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin", "LC_ALL": "C.UTF-8",
               "DEBIAN_FRONTEND": "noninteractive", "HOME": "/root"}
# A process tree of its own with /proc and terminals of its own; both end with it.
ENTER = """
set -eu
mount -t proc proc "$1/proc"
mount -t devpts devpts "$1/dev/pts" -o newinstance,ptmxmode=0666,mode=620
[ -e "$1/dev/ptmx" ] || touch "$1/dev/ptmx"
mount --bind "$1/dev/pts/ptmx" "$1/dev/ptmx"
exec chroot "$3" "$1" bash -euc 'cd "$1"; eval "$2"' bash "$2" "$4"
"""
INSTALLED = """
apt-get -qq -y install --no-install-recommends man-db systemd gcc libc6-dev pkgconf /packages/*.deb >/tmp/said 2>&1 || \
    { cat /tmp/said; exit 1; }
for page in /usr/share/man/man1/drehgeber*; do
    test -z "$(MANWIDTH=80 man --warnings=w -l "$page" 2>&1 >/dev/null)"
done
man drehgeber | head -n 4
test -z "$(systemd-analyze verify /lib/systemd/system/drehgeber@.service 2>&1)"
touch /etc/drehgeber/bench.ini
python3 -c '
import drehgeber
print(drehgeber.__version__, drehgeber.Encoder("s3684-rs485").request(bytes.fromhex("404202")).hex())'
printf '%s\\n' '#include <stdio.h>' '#include <drehgeber/drehgeber.h>' 'int main(void) { return puts(dg_version()) < 0; }' >/tmp/a.c
cc -Wall -Werror /tmp/a.c -o /tmp/a $(pkg-config --cflags --libs drehgeber)
/tmp/a
ldd /usr/bin/drehgeber | sed -n 's/.*\\(libgpiod[^ ]*\\) .*/\\1/p'
"""
# Root has no need of sudo, nobody is there to answer apt, and there is no screen.
TYPED = """
sudo() { yes | "$@"; }
xdg-open() { grep -q WebAssembly "$1"; }
"""


def run(root, command, folder="/", user=None, environment=None):
    """In the root; what it prints is printed. @return that"""
    ended = subprocess.run(
        ["unshare", "--mount", "--pid", "--fork", "--kill-child", "bash", "-c", ENTER, "enter", str(root), folder,
         f"--userspec={user or '0:0'}", command],
        env={**ENVIRONMENT, **(environment or {})}, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        check=False)
    print(ended.stdout, end="", flush=True)
    if ended.returncode != 0:
        sys.exit(f"{root}: {command.strip().splitlines()[0]}: {ended.returncode}")
    return ended.stdout


def copy(source, root):
    subprocess.run(["cp", "-a", str(source), str(root)], check=True)


def make_root(root, suite):
    """A Debian with nothing but what every one has, in a new folder; what debootstrap says is in a file beside it."""
    root.parent.mkdir(parents=True, exist_ok=True)
    with open(root.with_suffix(".log"), "w", encoding="utf-8") as log:
        subprocess.run(["debootstrap", "--variant=minbase", suite, str(root), MIRROR], check=True, stdout=log)
    shutil.copy("/etc/resolv.conf", root / "etc/resolv.conf")
    (root / "etc/dpkg/dpkg.cfg.d/roots").write_text("force-unsafe-io\n")  # nobody needs it after a power cut


def blocks_of(page, mark, language="sh"):
    """What a page tells a newcomer to type: its blocks with `run: elsewhere, MARK`."""
    text = Path(page).read_text(encoding="utf-8")
    return re.findall(rf"^<!-- run: elsewhere, {re.escape(mark)} -->\n```{language}\n(.*?)^```$", text, re.M | re.S)
