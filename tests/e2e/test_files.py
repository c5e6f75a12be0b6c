# SPDX-License-Identifier: MIT
"""Files that clients of the control plane name, and those that a start names: what may be written."""
import itertools
import os
import resource
import signal
import socket
import stat
import subprocess
import threading
import time
from pathlib import Path

import pytest

from rig import PATIENCE_S, PROGRAM, Client, run_refused, start_rig

# An encoder for each kind of trace; `image.*` are EEPROMs in use below the folder.
RIG = """
[rig]
control = unix:{here}/s
control = tcp:127.0.0.1:0
{key}
[encoder biss]
model = s3684-biss
wire = sim
nvm = {folder}/image.vcd
[encoder can]
model = f3668
wire = slcan
nvm = {folder}/image.csv
[encoder ring]
model = ocd-ib-k3
wire = modbus:127.0.0.1:0
"""
# What can be written: name, encoder, command, ending.
KINDS = [
    ("recording", "biss", "SHAF:REC:{}", "csv"),
    ("vcd", "biss", "TRAC:{}", "vcd"),
    ("candump", "can", "TRAC:{}", "log"),
    ("pcapng", "can", "TRAC:{}", "pcapng"),
    ("cycles", "ring", "TRAC:{}", "csv"),
]
BUSY = (-256, -257)
FOREIGN = b"not of this program, 1\n" * 300


class Bench:
    """A rig, a folder that is its clients' and one that is not, and a client."""

    def __init__(self, here: Path, way: str):
        self.here, self.numbers = here, itertools.count()
        self.folder, self.outside = here / "folder", here / "outside"
        self.folder.mkdir()
        self.outside.mkdir()
        transport, _, how = way.partition(" ")
        key = "files = folder" if how == "key" else ""
        (here / "rig.ini").write_text(RIG.format(here=here, folder=self.folder, key=key))
        options = ["--files", self.folder] if how == "option" else []
        self.rig = start_rig(here / "rig.ini", *options, cwd=self.folder if how == "here" else here)
        self.address = self.rig.controls[transport == "tcp"]
        self.client = Client(self.address)

    def place(self) -> Path:
        """A folder of one test's own, below the clients' one."""
        place = self.folder / f"{next(self.numbers)}"
        place.mkdir()
        return place

    def begin(self, kind, name) -> int:
        """The error code of a start, 0 for none; what was started is ended."""
        _, encoder, command, _ = kind
        self.client.do(f"INST:SEL {encoder}")
        code = self.client.error(f'{command.format("STAR")} "{name}"')
        if code == 0 and encoder == "ring":
            time.sleep(0.01)  # its header comes with the first cycle
        self.client.do(command.format("STOP"))
        return code

    def close(self):
        self.client.close()
        assert self.rig.end() == 0
        assert self.rig.clean_up() == []


WAYS = ["unix here", "unix option", "unix key", "tcp option", "tcp key"]


@pytest.fixture(scope="module", params=WAYS)
def bench(request, tmp_path_factory):
    one = Bench(tmp_path_factory.mktemp("files"), request.param)
    yield one
    one.close()


@pytest.fixture(params=KINDS, ids=[kind[0] for kind in KINDS])
def kind(request):
    return request.param


def everything(*folders: Path) -> dict:
    """What lies in these folders, byte for byte; links by where they lead."""
    found = {}
    for path in itertools.chain(*(folder.rglob("*") for folder in folders)):
        mode = path.lstat().st_mode
        if stat.S_ISLNK(mode):
            found[path] = os.readlink(path)
        else:
            found[path] = path.read_bytes() if stat.S_ISREG(mode) else stat.S_IFMT(mode)
    return found


# --- where it may lie -----------------------------------------------------------------------------

# Names that are refused whatever lies there.
NAMES = {
    "absolute_and_new": "{outside}/new.{ending}",
    "upwards": "../x.{ending}",
    "upwards_from_below": "{place}/../../outside/x.{ending}",
    "upwards_from_the_folder": "{folder}/../outside/x.{ending}",
    "device": "/dev/null",
    "process_file": "/proc/self/cwd/x.{ending}",
    "wrong_ending": "{place}/x.txt",
    "no_ending": "{place}/{ending}",
    "ending_of_another_kind": "{place}/x.nvm",
    "ending_and_more": "{place}/x.{ending}.txt",
    "missing_folder": "{place}/none/x.{ending}",
    "file_as_a_folder": "image.csv/x.{ending}",
    "too_long": "{place}/" + "x" * 256 + ".{ending}",
    "nothing": "",
    "the_folder_itself": ".",
    "slash_behind": "{place}/x.{ending}/",
}


# Each makes something in the place; the name a client tries is x.ENDING there, or what is answered.

def absolute(bench, place, ending):
    (bench.outside / "precious").write_bytes(FOREIGN)
    return bench.outside / "precious"


def absolute_with_the_ending(bench, place, ending):
    (bench.outside / f"absolute.{ending}").write_bytes(FOREIGN)
    return bench.outside / f"absolute.{ending}"


def neighbour_with_the_same_beginning(bench, place, ending):
    (bench.here / "folder2").mkdir(exist_ok=True)
    return bench.here / f"folder2/x.{ending}"


def symbolic_link(bench, place, ending):
    (bench.outside / f"linked.{ending}").write_bytes(FOREIGN)
    (place / f"x.{ending}").symlink_to(bench.outside / f"linked.{ending}")


def symbolic_link_to_nothing(bench, place, ending):
    (place / f"x.{ending}").symlink_to(bench.outside / f"nothing.{ending}")


def symbolic_link_inside(bench, place, ending):
    (place / f"y.{ending}").touch()
    (place / f"x.{ending}").symlink_to(f"y.{ending}")


def folder_behind_a_link(bench, place, ending):
    (place / "sub").symlink_to(bench.outside)
    return f"{place.name}/sub/x.{ending}"


def hard_link(bench, place, ending):
    (bench.outside / f"hard.{ending}").write_bytes(FOREIGN)
    (place / f"x.{ending}").hardlink_to(bench.outside / f"hard.{ending}")


def pipe(bench, place, ending):
    os.mkfifo(place / f"x.{ending}")


def folder(bench, place, ending):
    (place / f"x.{ending}").mkdir()


def unix_socket(bench, place, ending):
    with socket.socket(socket.AF_UNIX) as one:
        one.bind(str(place / "x"))
    (place / "x").rename(place / f"x.{ending}")


def eeprom_of_yesterday(bench, place, ending):
    (place / f"x.{ending}").write_bytes((bench.folder / "image.csv").read_bytes())


def foreign(bench, place, ending):
    (place / f"x.{ending}").write_bytes(FOREIGN)


def foreign_of_one_byte(bench, place, ending):
    (place / f"x.{ending}").write_bytes(b"t")


def foreign_that_names_us(bench, place, ending):
    text = f"#!/bin/sh\n# $comment drehgeber: time_s,angle_deg time_s,in_0 {ending}\n"
    (place / f"x.{ending}").write_text(text)


def foreign_with_more_columns(bench, place, ending):
    (place / f"x.{ending}").write_text("time_s,angle_deg,torque_nm\n0,0,0\n")


def hard_link_to_their_own(bench, place, ending):
    kind = next(kind for kind in KINDS if kind[3] == ending and kind[0] != "cycles")
    assert bench.begin(kind, place / f"y.{ending}") == 0
    (place / f"x.{ending}").hardlink_to(place / f"y.{ending}")


def foreign_with_zeros(bench, place, ending):
    (place / f"x.{ending}").write_bytes(bytes(5000))


def eeprom_in_use(bench, place, ending):
    return "image.vcd" if ending == "vcd" else "image.csv"


MADE = (
    absolute, absolute_with_the_ending, neighbour_with_the_same_beginning, symbolic_link,
    symbolic_link_to_nothing, symbolic_link_inside, folder_behind_a_link, hard_link, pipe, folder,
    unix_socket, eeprom_of_yesterday, foreign, foreign_of_one_byte, foreign_that_names_us,
    foreign_with_more_columns, hard_link_to_their_own, foreign_with_zeros, eeprom_in_use,
)
REFUSED = {make.__name__: make for make in MADE} | NAMES


def tried(bench, what: str, ending: str) -> str:
    """The name that a client tries, once what it leads to is there."""
    place, make = bench.place(), REFUSED[what]
    name = make if isinstance(make, str) else make(bench, place, ending) or "{place}/x.{ending}"
    return str(name).format(place=place.name, folder=bench.folder, outside=bench.outside, ending=ending)


@pytest.mark.parametrize("what", REFUSED)
def test_what_is_not_theirs_stays_as_it_is(bench, kind, what):
    name = tried(bench, what, kind[3])
    before = everything(bench.here)
    assert bench.begin(kind, name) in BUSY, name
    assert everything(bench.here) == before


@pytest.mark.parametrize("form", ["{place.name}/x.{ending}", "{place}/x.{ending}",
                                  "./{place.name}/../{place.name}//x.{ending}"])
def test_what_is_new_is_made_and_what_is_theirs_is_replaced(bench, kind, form):
    place = bench.place()
    file = place / f"x.{kind[3]}"
    name = form.format(place=place, ending=kind[3])
    assert bench.begin(kind, name) == 0
    first = file.read_bytes()
    with file.open("ab") as more:
        more.write(b"0,0\n" * 5000)
    inode = file.stat().st_ino
    if kind[0] == "candump":  # such a file has no header, so nobody can tell whose it is
        assert bench.begin(kind, name) == -257
        assert file.read_bytes() == first + b"0,0\n" * 5000
    else:
        assert bench.begin(kind, name) == 0
        assert 0 < file.stat().st_size < len(first) + 20000
    assert file.stat().st_ino == inode
    assert file.stat().st_mode & 0o133 == 0
    assert sorted(path.name for path in place.iterdir()) == [file.name]


def test_an_empty_file_is_nobodys(bench, kind):
    file = bench.place() / f"x.{kind[3]}"
    file.touch()
    assert bench.begin(kind, file) == 0
    assert file.stat().st_size > 0 or kind[0] == "candump"


@pytest.mark.parametrize("kind, other", [
    pytest.param(kind, other, id=f"{kind[0]} over {other[0]}") for kind in KINDS for other in KINDS
    if kind is not other and other[0] != "candump"])
def test_one_kind_does_not_replace_another(bench, kind, other):
    place = bench.place()
    assert bench.begin(other, f"{place.name}/a.{other[3]}") == 0
    (place / f"a.{other[3]}").rename(place / f"x.{kind[3]}")
    before = everything(place)
    assert bench.begin(kind, f"{place.name}/x.{kind[3]}") in BUSY
    assert everything(place) == before


@pytest.mark.parametrize("name", ["/etc/hostname", "/etc/passwd", "/", "/dev/full", "/dev/stdout"])
def test_files_of_the_machine(bench, kind, name):
    before = os.stat(name)
    assert bench.begin(kind, name) in BUSY
    after = os.stat(name)
    assert (before.st_ino, before.st_size, before.st_mtime_ns, before.st_mode) == (
        after.st_ino, after.st_size, after.st_mtime_ns, after.st_mode)


def test_the_error_says_what_would_be_right(bench):
    bench.client.do("INST:SEL biss")
    for name, what in [(f"{bench.outside}/x.csv", "below"), ("../x.csv", "below"), ("x.txt", ".csv")]:
        bench.client.send(f'SHAF:REC:STAR "{name}"')
        told = bench.client.ask("SYST:ERR?")
        assert what in told, told


def swapped(file: Path, target: Path, stop: threading.Event):
    """Takes turns at being no file, and a link to somebody's; the next name is made aside."""
    aside = file.with_name("aside")
    while not stop.is_set():
        aside.symlink_to(target)
        aside.rename(file)
        file.unlink(missing_ok=True)


@pytest.mark.parametrize("what", ["file", "folder"])
def test_a_link_that_comes_while_it_is_opened(bench, what):
    place = bench.place()
    target = bench.outside / f"{place.name}"
    target.mkdir()
    (target / "x.csv").write_bytes(FOREIGN)
    swap = (place / "x.csv", target / "x.csv") if what == "file" else (place / "x", target)
    name = f"{place.name}/x.csv" if what == "file" else f"{place.name}/x/x.csv"
    stop = threading.Event()
    swapper = threading.Thread(target=swapped, args=(*swap, stop))
    swapper.start()
    try:
        codes = {bench.begin(KINDS[0], name) for _ in range(400)}
        codes |= {bench.begin(KINDS[0], f"{name[:-4]}{i}.csv") for i in range(100)}
    finally:
        stop.set()
        swapper.join(PATIENCE_S)
    assert codes & {-256, -257} and codes <= {0, -256, -257}
    assert everything(target) == {target / "x.csv": FOREIGN}


def test_nothing_is_left_open(bench):
    descriptors = Path(f"/proc/{bench.rig.pid}/fd")
    place = bench.place()
    names = [tried(bench, what, "csv") for what in ("absolute", "upwards", "pipe", "wrong_ending",
                                                    "missing_folder", "eeprom_in_use")]
    before = len(list(descriptors.iterdir()))
    for name in names * 5 + [f"{place.name}/new.csv"] * 5:
        bench.begin(KINDS[0], name)
        bench.client.error(f'SHAF:PROF "{name}"')
        bench.client.error(f'WORL:TEMP:PROF "{name}"')
    assert len(list(descriptors.iterdir())) == before


# --- motions that are read ------------------------------------------------------------------------

MOTION = "time_s,angle_deg\n0,45\n1,45\n"


def angle(bench) -> float:
    return float(bench.client.ask("SHAF:POS?"))


def test_a_motion_is_read_from_the_folder(bench):
    place = bench.place()
    (place / "m.csv").write_text(MOTION)
    for name in (f"{place.name}/m.csv", place / "m.csv"):
        bench.client.do("SHAF:POS 0")
        bench.client.do(f'SHAF:PROF "{name}"')
        assert angle(bench) == 45
    bench.client.do('SHAF:PROF "90DEG"')
    assert angle(bench) == 90


@pytest.mark.parametrize("what", ["absolute", "absolute_with_the_ending", "upwards", "symbolic_link",
                                  "symbolic_link_inside", "folder_behind_a_link", "pipe", "folder",
                                  "unix_socket", "process_file", "missing_folder", "too_long"])
def test_a_motion_from_elsewhere_is_not_read(bench, what):
    name = tried(bench, what, "csv")
    for path in (bench.outside, bench.folder):  # whatever it leads to would be a motion
        for file in path.rglob("*"):
            if file.is_file() and file.name != "image.csv" and file.name != "image.vcd":
                file.write_text(MOTION)
    if what == "upwards":
        (bench.here / "x.csv").write_text(MOTION)
    bench.client.do("SHAF:POS 10")
    assert bench.client.error(f'SHAF:PROF "{name}"') in (-224, -256)
    assert angle(bench) == 10


@pytest.mark.parametrize("name", ["/dev/zero", "/dev/random", "/proc/self/mem"])
def test_a_motion_from_a_device_holds_up_nobody(bench, name):
    begin = time.monotonic()
    assert bench.client.error(f'SHAF:PROF "{name}.csv"') == -256
    assert bench.client.error(f'SHAF:PROF "{name}"') in (-224, -256)
    assert time.monotonic() - begin < 2


def test_what_is_in_a_foreign_file_is_not_told(bench):
    (bench.outside / "secret.csv").write_text("hidden words\n")
    bench.client.send(f'SHAF:PROF "{bench.outside}/secret.csv"')
    assert "hidden" not in bench.client.ask("SYST:ERR?")


# --- courses of the world, which are read likewise -------------------------------------------------

def test_a_course_is_read_from_the_folder(bench):
    place = bench.place()
    (place / "c.csv").write_text("0,45\n")
    for name in (f"{place.name}/c.csv", place / "c.csv"):
        bench.client.do("WORL:DEF")
        bench.client.do(f'WORL:TEMP:PROF "{name}"')
        assert bench.client.ask("WORL:TEMP?") == "45.000"


@pytest.mark.parametrize("what", ["absolute", "absolute_with_the_ending", "upwards", "symbolic_link",
                                  "folder_behind_a_link", "pipe", "folder", "missing_folder"])
def test_a_course_from_elsewhere_is_not_read(bench, what):
    name = tried(bench, what, "csv")
    bench.client.do("WORL:DEF")
    assert bench.client.error(f'WORL:TEMP:PROF "{name}"') in (-224, -256)
    assert bench.client.ask("WORL:TEMP?;TEMP:PROF?") == '37.000;""'


# --- without a folder -----------------------------------------------------------------------------

def test_tcp_has_no_folder_unless_one_is_given(tmp_path):
    bench = Bench(tmp_path, "tcp here")
    (bench.folder / "m.csv").write_text(MOTION)
    before = everything(tmp_path)
    for kind in KINDS:
        assert bench.begin(kind, f"new.{kind[3]}") in BUSY
        assert bench.begin(kind, bench.folder / f"new.{kind[3]}") in BUSY
    assert bench.client.error('SHAF:PROF "m.csv"') == -256
    assert bench.client.error('WORL:TEMP:PROF "m.csv"') == -256
    bench.client.send('SHAF:REC:STAR "x.csv"')
    assert "files = DIR" in bench.client.ask("SYST:ERR?")
    bench.client.do('SHAF:PROF "60RPM"')
    assert everything(tmp_path) == before
    bench.close()


@pytest.mark.parametrize("folder", ["none", "file"])
def test_a_folder_that_is_none(tmp_path, folder):
    (tmp_path / "file").touch()
    assert "--files" in run_refused(1, "run", "s3684-biss", "--files", folder, cwd=tmp_path)
    rig = tmp_path / "rig.ini"
    rig.write_text(f"[rig]\nfiles = {folder}\n[encoder a]\nmodel = s3684-biss\nwire = sim\n")
    assert f"{rig}:2: files: " in run_refused(1, "run", rig)
    # ... and what the command line says goes before what the file says
    bench = start_rig(rig, "--files", tmp_path)
    assert bench.end() == 0 and bench.clean_up() == []


@pytest.mark.parametrize("form", ["{}/", "{}//", "/"])
def test_names_from_the_root(tmp_path, form):
    rig = tmp_path / "rig.ini"
    rig.write_text(f"[rig]\ncontrol = unix:s\nfiles = {form.format(tmp_path)}\n"
                   "[encoder a]\nmodel = s3684-biss\nwire = sim\n")
    bench = start_rig(rig)
    try:
        with Client(f"unix:{tmp_path}/s") as client:
            client.do(f'SHAF:REC:STAR "{tmp_path}/x.csv"')
        assert bench.end() == 0
    finally:
        assert bench.clean_up() == []
    assert (tmp_path / "x.csv").stat().st_size > 0


# --- starts that are refused ----------------------------------------------------------------------

TRACED = {
    "vcd": "[encoder a]\nmodel = s3684-rs485\nwire = pty\ntrace = {}\n",
    "log": "[encoder a]\nmodel = f3668\nwire = slcan\ntrace = {}\n",
    "pcapng": "[encoder a]\nmodel = f3668\nwire = slcan\ntrace = {}\n",
    "csv": "[encoder a]\nmodel = ocd-ib-k3\nwire = modbus:127.0.0.1:0\ntrace = {}\n",
}
REFUSED_LATE = {
    "wire": "[encoder z]\nmodel = s3684-rs485\nwire = tty:/dev/null\n",
    "control": "[rig]\ncontrol = tcp:127.0.0.1:{port}\n",
    "nvm": "[encoder z]\nmodel = s3684-rs485\nwire = pty\nnvm = none/z.nvm\n",
    "trace": "[encoder z]\nmodel = s3684-rs485\nwire = pty\ntrace = none/z.vcd\n",
}


@pytest.mark.parametrize("why", REFUSED_LATE)
@pytest.mark.parametrize("ending", TRACED)
def test_a_refused_start_changes_no_trace(tmp_path, ending, why):
    old, new = tmp_path / f"old.{ending}", tmp_path / f"new.{ending}"
    old.write_bytes(FOREIGN)
    with socket.create_server(("127.0.0.1", 0)) as taken:
        late = REFUSED_LATE[why].format(port=taken.getsockname()[1])
        for trace in (old, new):
            text = TRACED[ending].format(trace)
            (tmp_path / "rig.ini").write_text(late + text if "[rig]" in late else text + late)
            before = everything(tmp_path)
            run_refused(1, "run", tmp_path / "rig.ini")
            assert everything(tmp_path) == before


def test_the_command_line_too(tmp_path):
    old, new = tmp_path / "old.vcd", tmp_path / "new.vcd"
    old.write_bytes(FOREIGN)
    with socket.create_server(("127.0.0.1", 0)) as taken:
        address = f"tcp:127.0.0.1:{taken.getsockname()[1]}"
        for trace in (old, new):
            run_refused(1, "run", "s3684-biss", "--trace", trace, "--control", address)
    assert everything(tmp_path) == {old: FOREIGN}


def test_a_trace_is_not_the_eeprom(tmp_path, start, nvm):
    image = tmp_path / "e.vcd"
    assert start("--nvm", image).end() == 0
    before = image.read_bytes()
    for trace in (image, tmp_path / "./e.vcd", tmp_path / "link.vcd"):
        if not trace.exists():
            trace.symlink_to(image)
        run_refused(1, "run", "s3684-rs485", "--nvm", image, "--trace", trace)
        assert image.read_bytes() == before
    fresh = tmp_path / "fresh.vcd"
    run_refused(1, "run", "s3684-rs485", "--nvm", fresh, "--trace", fresh)
    assert not fresh.exists() or fresh.read_bytes()[:8] == before[:8]


def test_one_trace_file_of_two_wires(tmp_path):
    text = "[encoder {0}]\nmodel = s3684-rs485\nwire = pty\ntrace = one.vcd\n"
    (tmp_path / "rig.ini").write_text(text.format("a") + text.format("b"))
    (tmp_path / "one.vcd").write_bytes(FOREIGN)
    assert "already" in run_refused(2, "run", tmp_path / "rig.ini")
    assert (tmp_path / "one.vcd").read_bytes() == FOREIGN


# --- starts that are not --------------------------------------------------------------------------

def test_who_starts_it_may_replace_what_is_theirs(tmp_path, start):
    """The command line is its user's hand: as with a shell's >, foreign files and links too."""
    (tmp_path / "foreign.vcd").write_bytes(FOREIGN)
    (tmp_path / "link.vcd").symlink_to(tmp_path / "behind.vcd")
    for name in ("foreign.vcd", "link.vcd"):
        encoder = start("--trace", tmp_path / name)
        encoder.master().read_position()
        assert encoder.end() == 0
        text = (tmp_path / name).read_text()
        assert "$enddefinitions" in text and text.count("\n#") > 4
    assert (tmp_path / "link.vcd").is_symlink()


def test_a_trace_into_a_pipe_that_is_read(tmp_path, start):
    os.mkfifo(tmp_path / "pipe.vcd")
    reader = os.open(tmp_path / "pipe.vcd", os.O_RDONLY | os.O_NONBLOCK)
    encoder = start("--trace", tmp_path / "pipe.vcd")
    encoder.master().read_position()
    assert encoder.end() == 0
    got = b""
    while data := os.read(reader, 65536):
        got += data
    os.close(reader)
    assert b"$enddefinitions" in got and got.count(b"\n#") > 4


def few_bytes():
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, resource.RLIM_INFINITY))


def test_a_trace_that_cannot_begin_leaves_nothing_behind(tmp_path, tmp_path_factory):
    new = tmp_path / "new.vcd"
    # In a tree that counts lines it would tear the counters of all.
    counted = os.environ | {"GCOV_PREFIX": str(tmp_path_factory.mktemp("counters"))}
    said = run_refused(1, "run", "s3684-biss", "--trace", new, preexec_fn=few_bytes, env=counted)
    assert str(new) in said and "File too large" in said
    assert everything(tmp_path) == {}


def test_a_trace_says_why_it_ends(tmp_path, start):
    encoder = start("--trace", tmp_path / "t.vcd")
    encoder.limit_file_size((tmp_path / "t.vcd").stat().st_size + 5)
    with encoder.master() as master:
        deadline = time.monotonic() + PATIENCE_S
        while (said := encoder.errors.so_far()) == [] and time.monotonic() < deadline:
            master.read_position()
    assert len(said) == 1 and "t.vcd: File too large; the trace ends here" in said[0]
    encoder.limit_file_size(resource.RLIM_INFINITY)
    assert encoder.end() == 1
    assert "is not complete: File too large" in encoder.errors.wait()


# --- ends -----------------------------------------------------------------------------------------

@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGQUIT])
def test_signals_end_it_orderly(tmp_path, start, number):
    encoder = start("--control", f"unix:{tmp_path}/s", "--trace", tmp_path / "t.vcd")
    assert encoder.out.wait().startswith("control ")
    assert (tmp_path / "s").is_socket()
    link = next(tmp_path.glob("tty*"))
    assert encoder.end(number) == 0
    assert not link.is_symlink() and not (tmp_path / "s").exists()


def test_a_closed_terminal_ends_no_program_behind_nohup(tmp_path):
    process = subprocess.Popen(["nohup", PROGRAM, "run", "s3684-biss"], stdin=subprocess.DEVNULL,
                               stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    try:
        assert process.stdout.readline().startswith(b"ready")
        process.send_signal(signal.SIGHUP)
        with pytest.raises(subprocess.TimeoutExpired):
            process.wait(0.5)
        process.send_signal(signal.SIGTERM)
        assert process.wait(PATIENCE_S) == 0
    finally:
        if process.poll() is None:
            process.kill()
            process.wait(PATIENCE_S)
        process.stdout.close()
