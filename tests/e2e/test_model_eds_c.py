# SPDX-License-Identifier: MIT
"""EDS files as C: what `drehgeber model FILE.eds --c` writes is compiled, and does on the bus what the encoder of the file does."""
import os
import subprocess
from pathlib import Path

import pytest

from rig import REPOSITORY, run, run_refused

LIBRARY = Path(os.environ.get("LIBDREHGEBER", REPOSITORY / "build/release/libdrehgeber.so"))
WARNED = ["-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror", f"-I{REPOSITORY}/include"]
STRICT = [*WARNED, *os.environ.get("CFLAGS", "").split()]
# Another maker's encoder: cells with and without limits, signed ones, texts, what follows the node-ID, parts of the
# memory, a speed with a sign, cams; as a DCF with a node-ID and a bit rate.
OTHER = """[DeviceInfo]
VendorName=Acme "&" Co\u00fc ??/
ProductName=Other 3
BaudRate_125=1
BaudRate_500=1
[DeviceComissioning]
NodeID=0x21
Baudrate=500
[1000]
DataType=7
DefaultValue=0x00020196
[1005]
DataType=7
AccessType=rw
DefaultValue=0x80
[1008]
DataType=9
DefaultValue=Other 3
[1010sub0]
DataType=5
DefaultValue=2
[1010sub1]
DataType=7
AccessType=rw
[1010sub2]
DataType=7
AccessType=rw
[1011sub1]
DataType=7
AccessType=rw
[1011sub2]
DataType=7
AccessType=rw
[1017]
DataType=6
AccessType=rw
DefaultValue=50
HighLimit=100
[1018sub1]
DataType=7
DefaultValue=0x1234
[1018sub4]
DataType=7
DefaultValue=99
[1800sub1]
DataType=7
AccessType=rw
DefaultValue=$NODEID+0x180
[1800sub2]
DataType=5
AccessType=rw
DefaultValue=1
[1A00sub0]
DataType=5
AccessType=rw
DefaultValue=2
[1A00sub1]
DataType=7
AccessType=rw
DefaultValue=0x60040020
[1A00sub2]
DataType=7
AccessType=rw
DefaultValue=0x20030008
[2000]
DataType=3
AccessType=rw
DefaultValue=-5
LowLimit=-9
HighLimit=9
[2001]
DataType=7
AccessType=rw
DefaultValue=$NODEID+7
[2002]
DataType=7
DefaultValue=$NODEID+8
[2003]
DataType=5
AccessType=rwr
PDOMapping=1
DefaultValue=0xA5
[6000]
DataType=6
AccessType=rw
[6001]
DataType=7
AccessType=rw
DefaultValue=1000
[6002]
DataType=7
AccessType=rw
DefaultValue=100000
[6003]
DataType=7
AccessType=rw
[6004]
DataType=7
PDOMapping=1
[6030sub1]
DataType=4
[6300sub1]
DataType=5
[6301sub1]
DataType=5
AccessType=rw
DefaultValue=1
[6310sub1]
DataType=7
AccessType=rw
DefaultValue=10
[6320sub1]
DataType=7
AccessType=rw
DefaultValue=20000
[6501]
DataType=7
DefaultValue=3600
[6502]
DataType=6
DefaultValue=100
"""
# No value to write, no limits, no text: tables that are not there.
BARE = """[1000]
DataType=7
DefaultValue=0x00010196
[6004]
DataType=7
[6501]
DataType=7
DefaultValue=8192
"""
# A master that reads and writes every object there may be, saves, and goes on behind a power cycle.
PLAY = r"""
#include <stdio.h>
#include <string.h>
#include "drehgeber/cia406.h"
#include "drehgeber/host.h"
#include "drehgeber/model.h"

const struct dg_device *find_model(int argc, char **argv);
static _Alignas(16) unsigned char memory[1 << 18];
static unsigned char image[1 << 16];
static uint64_t now;
static unsigned char node;

/* Whether a read goes on with a segment, whose toggle is behind the last one's. */
static int listen(struct dg_host *host)
{
    struct dg_host_event event;
    int goes_on = 0;
    while (dg_host_receive(host, &event) == 1) {
        printf("%llu %03X", (unsigned long long)event.at, (unsigned)event.id);
        for (int i = 0; i < event.length; i++) {
            printf(" %02X", event.data[i]);
        }
        printf("\n");
        const int segment = (event.data[0] & 0xE1) == 0 || event.data[0] == 0x41;
        goes_on = event.id == 0x580u + node && segment;
    }
    return goes_on;
}

static int ask(struct dg_host *host, unsigned id, const unsigned char *data, unsigned char n)
{
    struct dg_host_event event = {.at = now, .id = id, .kind = DG_HOST_CAN, .length = n};
    memcpy(event.data, data, n);
    if (dg_host_send(host, &event) != DG_HOST_OK) {
        printf("not sent\n");
    }
    now += 20000000;
    (void)dg_host_step(host, now);
    return listen(host);
}

static void sdo(struct dg_host *host, int head, unsigned index, unsigned sub, uint32_t value)
{
    const unsigned char data[8] = {(unsigned char)head,        (unsigned char)index,       (unsigned char)(index >> 8),
                                   (unsigned char)sub,         (unsigned char)value,       (unsigned char)(value >> 8),
                                   (unsigned char)(value >> 16), (unsigned char)(value >> 24)};
    unsigned char more[8] = {0x60};
    for (int goes_on = ask(host, 0x600u + node, data, 8); goes_on; more[0] ^= 0x10) {
        goes_on = ask(host, 0x600u + node, more, 8);
    }
}

static void read_all(struct dg_host *host)
{
    static const unsigned from[][2] = {{0x1000, 0x102A}, {0x1800, 0x1804}, {0x1A00, 0x1A04}, {0x2000, 0x2004},
                                       {0x2100, 0x2170}, {0x3000, 0x3010}, {0x6000, 0x6005}, {0x6030, 0x6041},
                                       {0x6200, 0x6201}, {0x6300, 0x6338}, {0x6400, 0x6403}, {0x6500, 0x6510}};
    for (unsigned i = 0; i < sizeof from / sizeof *from; i++) {
        for (unsigned index = from[i][0]; index < from[i][1]; index++) {
            for (unsigned sub = 0; sub < 10; sub++) {
                sdo(host, 0x40, index, sub, 0);
            }
        }
    }
}

static void write_some(struct dg_host *host)
{
    static const struct { int head; unsigned index, sub; uint32_t value; } writes[] = {
        {0x2B, 0x1017, 0, 90}, {0x2B, 0x1017, 0, 500}, {0x2B, 0x2000, 0, 0xFFF7}, {0x2B, 0x2000, 0, 10},
        {0x23, 0x2001, 0, 77}, {0x2F, 0x2003, 0, 0x5A}, {0x23, 0x2002, 0, 1}, {0x23, 0x6003, 0, 5}, {0x23, 0x2140, 2, 4711},
        {0x2B, 0x6000, 0, 4}, {0x23, 0x6001, 0, 720}, {0x2F, 0x2120, 2, 0x30}, {0x23, 0x6401, 1, 3}, {0x2F, 0x6301, 1, 3},
        {0x2F, 0x1800, 2, 2}, {0x2F, 0x2100, 0, 4}, {0x2B, 0x6200, 0, 30}, {0x23, 0x6004, 0, 1}, {0x2B, 0x6031, 2, 50},
    };
    for (unsigned i = 0; i < sizeof writes / sizeof *writes; i++) {
        sdo(host, writes[i].head, writes[i].index, writes[i].sub, writes[i].value);
        sdo(host, 0x40, writes[i].index, writes[i].sub, 0);
    }
}

static void turn_shaft(struct dg_host *host)
{
    static const unsigned char start[2] = {1, 0};
    (void)ask(host, 0, start, 2);
    dg_host_shaft(host, now, INT64_C(5) << 31, INT64_C(1) << 33);
    for (int i = 0; i < 20; i++) {
        (void)ask(host, 0x80, start, 0);
    }
    sdo(host, 0x40, 0x6030, 1, 0);
}

static void told(const char *what, const char *text)
{
    printf("%s: %s\n", what, text == NULL ? "-" : text);
}

int main(int argc, char **argv)
{
    const struct dg_device *device = find_model(argc, argv);
    struct dg_host *host = device == NULL ? NULL : dg_host_init(memory, sizeof memory, device, &dg_cia406_wire);
    char text[16];
    if (host == NULL || dg_host_get(host, "node", text, sizeof text) < 0) {
        return 2;
    }
    unsigned number = 0;
    (void)sscanf(text, "%u", &number);
    node = (unsigned char)number;
    told(device->name, device->resolution);
    told(device->wire, dg_cia406_model_of(device)->device->name);
    told("vendor", ((const struct dg_co_file *)(const void *)dg_cia406_model_of(device)->device)->vendor);
    for (int i = 0; i < 3; i++) {
        printf("power %d\n", dg_host_power(host, now, true));
        now += 1000000000;
        (void)dg_host_step(host, now);
        (void)listen(host);
        read_all(host);
        write_some(host);
        turn_shaft(host);
        sdo(host, 0x23, i == 0 ? 0x1010 : 0x1011, i == 0 ? 1 : 2, i == 0 ? 0x65766173 : 0x64616F6C);
        const size_t n = dg_host_memory_size(host);
        (void)dg_host_memory_copy(host, image, sizeof image);
        for (size_t k = 0; k < n; k++) {
            printf("%02X", image[k]);
        }
        printf("\n");
    }
    return 0;
}
"""
READ = r"""
#include <stdio.h>
#include "drehgeber/cia406.h"
#include "drehgeber/model.h"

const struct dg_device *find_model(int argc, char **argv)
{
    static _Alignas(16) unsigned char made[1 << 20];
    static char text[1 << 18];
    FILE *file = fopen(argv[argc - 1], "rb");
    const struct dg_model_source from = {text, fread(text, 1, sizeof text, file), made, sizeof made};
    struct dg_model_made to = {.device = NULL};
    struct dg_model_flaw flaw;
    fclose(file);
    (void)dg_cia406_model_file.read(&from, &to, &flaw);
    return to.device;
}
"""
C = r"""
#include "drehgeber/devices.h"

extern const struct dg_device %(symbol)s;
const struct dg_device *find_model(int argc, char **argv);
const struct dg_device *find_model(int argc, char **argv)
{
    (void)argc;
    (void)argv;
    return &%(symbol)s;
}
"""


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("eds")
    (folder / "f3668.eds").write_text(run("eds", "f3668").stdout)
    (folder / "other.dcf").write_bytes(OTHER.encode("latin-1"))
    (folder / "bare.eds").write_text(BARE)
    (folder / "play.c").write_text(PLAY)
    (folder / "read.c").write_text(READ)
    return folder


def build(folder, name, *sources):
    subprocess.run(["gcc", *STRICT, "-o", name, "play.c", *sources, LIBRARY, f"-Wl,-rpath,{LIBRARY.parent}"], cwd=folder, check=True)
    return folder / name


@pytest.fixture(scope="module")
def played(files):
    """What a master hears of the encoder that is read from a file."""
    program = build(files, "reader", "read.c")

    def play(file):
        return subprocess.run([program, files / file], capture_output=True, check=True).stdout.decode("latin-1").splitlines()
    return play


def made(files, file):
    ended = run("model", files / file, "--c")
    assert (ended.returncode, ended.stderr) == (0, ""), ended.stderr
    return ended.stdout


def play_c(files, text, symbol):
    (files / f"{symbol}.c").write_text(text)
    (files / f"{symbol}_main.c").write_text(C % {"symbol": symbol})
    program = build(files, symbol, f"{symbol}_main.c", f"{symbol}.c")
    return subprocess.run([program], capture_output=True, check=True).stdout.decode("latin-1").splitlines()


@pytest.mark.parametrize("file, symbol, heard", [
    ("f3668.eds", "model_f3668", "5BF 43 04 60 00 "), ("other.dcf", "model_other_3", "1A1 "), ("bare.eds", "model_eds", "5BF 43 01 65 00 00 20")])
def test_what_is_compiled_answers_as_what_was_read(files, played, file, symbol, heard):
    wanted = played(file)
    assert len(wanted) > 2000 and any(heard in line for line in wanted)
    assert play_c(files, made(files, file), symbol) == wanted


@pytest.mark.parametrize("before, after", [
    ("DG_CIA406_VALUE_MUR, ", "DG_CIA406_VALUE_TMR, "), ("DG_CO_ROW(0x2003, ", "DG_CO_ROW(0x2004, "), ("out[0] = 6", "out[0] = 4")])
def test_the_comparison_sees_what_differs(files, played, before, after):
    text = made(files, "other.dcf")
    assert before in text
    assert play_c(files, text.replace(before, after), "model_other_3") != played("other.dcf")


def test_it_names_its_protocol_alone(files):
    (files / "small.c").write_text(made(files, "other.dcf"))
    # as for a firmware: sanitizers and coverage of the tree would add names and data of their own
    subprocess.run(["gcc", *WARNED, "-Os", "-fno-pic", "-fno-pie", "-c", "small.c"], cwd=files, check=True)
    listed = subprocess.check_output(["nm", "small.o"], cwd=files, text=True).splitlines()
    needed = {line.split()[-1] for line in listed if line.split()[-2] == "U"}
    assert needed and all(name.startswith(("dg_co_", "dg_cia406_")) for name in needed), needed
    assert not [line for line in listed if line.split()[-2] in "BbDC"]


def test_a_program_has_no_reader(files):
    """Linked with the archive, as a firmware is."""
    archive = LIBRARY.parent / "libdrehgeber.a"
    (files / "model_other_3.c").write_text(made(files, "other.dcf"))
    (files / "main.c").write_text(C % {"symbol": "model_other_3"})
    flags = os.environ.get("CFLAGS", "").split()
    subprocess.run(["gcc", "-std=c11", *flags, f"-I{REPOSITORY}/include", "-o", "alone", "play.c", "main.c", "model_other_3.c", archive],
                   cwd=files, check=True)
    linked = {line.split()[-1] for line in subprocess.check_output(["nm", "alone"], cwd=files, text=True).splitlines()}
    assert "dg_co_row_hooks" in linked
    assert not linked & {"dg_co_read", "dg_co_scan_text", "dg_co_make_rows", "dg_cia406_read", "dg_biss_stack", "dg_plan_read"}


def test_what_is_refused():
    assert "none.eds: " in run_refused(2, "model", "none.eds", "--c")
