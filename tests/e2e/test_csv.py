# SPDX-License-Identifier: MIT
"""CSV files that a client names: what is no text of lines is refused at once, and reading holds up no other wire."""
import os
import resource
import select
import subprocess
from pathlib import Path

import pytest

from hiperface_master import Master
from rig import Client, run_refused, start_rig

RIG = """
[rig]
control = unix:{here}/s
control = unix:{here}/other
[shaft axis]
[encoder line]
model = s3684-rs485
wire = pty:{here}/line
shaft = axis
[encoder biss]
model = s3684-biss
wire = sim
"""
# The longest turn of the loop, in processor time, which others on the machine do not change.
TURNS = """
#define _GNU_SOURCE
#include <fcntl.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/epoll.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>
static uint64_t *longest, begin;
static uint64_t spent(void)
{
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}
static void end_turn(void)
{
    if (longest == NULL) {
        longest = mmap(NULL, 8, PROT_READ | PROT_WRITE, MAP_SHARED, open(getenv("LONGEST"), O_RDWR | O_CLOEXEC), 0);
    } else if (spent() - begin > *longest) {
        *longest = spent() - begin;
    }
}
int epoll_pwait2(int fd, struct epoll_event *events, int n, const struct timespec *wait, const sigset_t *mask)
{
    end_turn();
    const long result = syscall(SYS_epoll_pwait2, fd, events, n, wait, mask, (size_t)8);
    begin = spent();
    return (int)result;
}
int epoll_wait(int fd, struct epoll_event *events, int n, int wait)
{
    end_turn();
    const long result = syscall(SYS_epoll_pwait, fd, events, n, wait, NULL, (size_t)8);
    begin = spent();
    return (int)result;
}
"""
TURN_MAX_NS = 5_000_000
WAYS = ['SHAF:PROF "{}"', 'WORL:TEMP:PROF "{}"']
NO_TEXT = "no text, as it has a NUL; expected lines of text"
TOO_LONG = "more than 198 characters; expected a shorter line of text"
FILE_NAME_ERROR = -256
MIB = 1 << 20
SLACK_MIB = 8  # what a rig may need more for a moment
REFUSED_WITHIN_NS = 50_000_000  # of processor time
ATTEMPTS = 10  # a machine that stands still for a moment proves nothing
LINES = 1_000_000


class Bench:
    def __init__(self, here: Path, turns: Path):
        (here / "longest").write_bytes(bytes(8))
        environment = {**os.environ, "LD_PRELOAD": str(turns), "LONGEST": str(here / "longest"),
                       "ASAN_OPTIONS": "verify_asan_link_order=0"}
        self.rig = start_rig(here / "rig.ini", cwd=here, env=environment)
        self.client, self.other = (Client(address) for address in self.rig.controls)
        self.client.do("INST:SEL biss")
        self.master = Master(str(here / "line"))

    def cpu_ns(self) -> int:
        return int(Path(f"/proc/{self.rig.pid}/schedstat").read_text().split()[0])

    def memory(self, name: str) -> int:
        """VmHWM, the most there was in memory, or VmSize."""
        status = Path(f"/proc/{self.rig.pid}/status").read_text()
        return int(status.partition(f"{name}:")[2].split()[0]) * 1024


@pytest.fixture(scope="module")
def turns(tmp_path_factory):
    source = tmp_path_factory.mktemp("turns") / "turns.c"
    source.write_text(TURNS)
    subprocess.run(["gcc", "-shared", "-fPIC", "-O2", "-o", source.with_suffix(".so"), source], check=True)
    return source.with_suffix(".so")


@pytest.fixture
def bench(tmp_path, turns):
    (tmp_path / "rig.ini").write_text(RIG.format(here=tmp_path))
    one = Bench(tmp_path, turns)
    yield one
    one.master.close()
    one.client.close()
    one.other.close()
    assert one.rig.clean_up() == []


def write_lines(path: Path, count: int):
    with path.open("w") as file:
        file.writelines(f"{i / 1000:.3f},{i % 8000 / 100:.2f}\n" for i in range(count))


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("kind", ["sparse", "one line", "comment", "points"])
def test_no_text_of_lines_is_refused_at_once(bench, tmp_path, kind, way):
    """Two gigabytes without an end of a line; a line of 64 MB; the same behind points."""
    with (tmp_path / "x.csv").open("wb") as file:
        file.write({"sparse": b"", "one line": b"1" * 64 * MIB, "comment": b"#" * 64 * MIB,
                    "points": b"0,0\n1,1\n" + b"2," * 32 * MIB}[kind])
        if kind == "sparse":
            file.truncate(2 << 30)
    cpu, memory = bench.cpu_ns(), bench.memory("VmHWM")
    bench.client.send(way.format("x.csv"))
    told, said = bench.client.ask("SYST:ERR?"), NO_TEXT if kind == "sparse" else TOO_LONG
    assert told.startswith(f"{FILE_NAME_ERROR},") and f"x.csv:{3 if kind == 'points' else 1}: {said}" in told
    assert bench.cpu_ns() - cpu < REFUSED_WITHIN_NS
    assert bench.memory("VmHWM") - memory < SLACK_MIB * MIB


@pytest.mark.parametrize("way", WAYS)
def test_a_long_file_holds_up_no_other_wire(bench, tmp_path, way):
    """A million points: no turn of the loop takes 5 ms, and 42h of another encoder is answered meanwhile."""
    write_lines(tmp_path / "x.csv", LINES)
    longest_ns = []
    while len(longest_ns) < ATTEMPTS and min(longest_ns, default=TURN_MAX_NS) >= TURN_MAX_NS:
        with (tmp_path / "longest").open("r+b") as file:  # the rig has it in its memory
            file.write(bytes(8))
        bench.client.send(way.format("x.csv") + "\nSYST:ERR?")
        answers = 0
        while not select.select([bench.client.line], [], [], 0)[0]:
            bench.master.read_position()
            answers += 1
        assert bench.client.answers.readline().startswith("0,") and answers > 5
        longest_ns.append(int.from_bytes((tmp_path / "longest").read_bytes(), "little"))
    assert 0 < min(longest_ns) < TURN_MAX_NS, longest_ns


@pytest.mark.parametrize("way", WAYS)
def test_what_stands_behind_a_file_is_done(bench, tmp_path, way):
    """However many turns of the loop the file takes: an answer behind it comes without another byte from the client."""
    for count in range(100, 1500, 100):
        write_lines(tmp_path / f"{count}.csv", count)
        bench.client.line.sendall(f'{way.format(f"{count}.csv")}\nSYST:ERR?\n'.encode())
        assert bench.client.answers.readline().startswith("0,"), count


def test_a_file_of_a_client_has_a_bound(bench, tmp_path):
    write_lines(tmp_path / "x.csv", (1 << 20) + 1)
    bench.client.send('SHAF:PROF "x.csv"')
    assert "x.csv:1048577: more than 1048576 points" in bench.client.ask("SYST:ERR?")


@pytest.mark.parametrize("way", WAYS)
def test_no_memory_is_not_the_end_of_a_file(bench, tmp_path, way):
    """A course is whole, or refused; what was followed goes on. With memory the same file is fine."""
    write_lines(tmp_path / "x.csv", LINES)
    (tmp_path / "y.csv").write_text("0,1\n1000,1\n")
    bench.client.do(way.format("y.csv"))
    hard = resource.prlimit(bench.rig.pid, resource.RLIMIT_AS)[1]
    resource.prlimit(bench.rig.pid, resource.RLIMIT_AS, (bench.memory("VmSize") + SLACK_MIB * MIB, hard))
    bench.client.send(way.format("x.csv"))
    told = bench.client.ask("SYST:ERR?")
    assert told.startswith(f"{FILE_NAME_ERROR},") and "no memory for so many lines" in told
    assert "y.csv" in bench.client.ask("SHAF:PROF?;:WORL:TEMP:PROF?")
    resource.prlimit(bench.rig.pid, resource.RLIMIT_AS, (hard, hard))
    bench.client.do(way.format("x.csv"))
    assert "x.csv" in bench.client.ask("SHAF:PROF?;:WORL:TEMP:PROF?")


def test_a_start_refuses_it_likewise(tmp_path):
    """With less memory than the line has."""
    (tmp_path / "x.csv").write_bytes(b"0,0\n" + b" " * 64 * MIB)
    limit = (48 * MIB, resource.getrlimit(resource.RLIMIT_AS)[1])
    line = run_refused(1, "run", "s3684-biss", "--shaft", "x.csv", cwd=tmp_path,
                       preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, limit))
    assert f"x.csv:2: {TOO_LONG}" in line
