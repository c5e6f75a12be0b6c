/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <linux/openat2.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cmocka.h>

#include "plan_rig.h"
#include "wire.h"
#include "wire_list.h"

#define FILE_NAME "rig.ini"

static char folder[] = "/tmp/test_plan.XXXXXX";

static int make_folder(void **state)
{
    (void)state;
    return mkdtemp(folder) == NULL || chdir(folder) != 0 || mkdir("sub", 0700) != 0 ? -1 : 0;
}

static int remove_folder(void **state)
{
    (void)state;
    (void)unlink(FILE_NAME);
    (void)unlink("sub/" FILE_NAME);
    return rmdir("sub") != 0 || chdir("/") != 0 || rmdir(folder) != 0 ? -1 : 0;
}

static void write_bytes(const char *path, const char *bytes, size_t n)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, n, file), n);
    assert_int_equal(fclose(file), 0);
}

static void read_good(struct dg_plan *plan, const char *text)
{
    struct lx_error error = {.right = ""};
    write_bytes(FILE_NAME, text, strlen(text));
    if (lx_plan_read(plan, FILE_NAME, &error) != 0) {
        fail_msg("%s", lx_error_line(&error).text);
    }
}

static void assert_all_zero(const struct dg_plan *plan)
{
    static const struct dg_plan zero;
    assert_memory_equal(plan, &zero, sizeof zero);
}

/* Every section and key. */
static const char everything[] = "; a comment\n"
                                 "[rig]\n"
                                 "name = bench\n"
                                 "control = tcp:127.0.0.1:5025\n"
                                 "control = unix:sock\n"
                                 "[shaft main]\n"
                                 "motion = 60RPM\n"
                                 "[shaft pitch] ; geared\n"
                                 "driver = MAIN\n"
                                 "ratio = 1:-10\n"
                                 "[bus ring]\n"
                                 "wire = modbus\n"
                                 "trace = ring.csv\n"
                                 "cycle = 2000\n"
                                 "[encoder a1]\n"
                                 "model = ocd-ib-k3\n"
                                 "bus = Ring\n"
                                 "shaft = pitch\n"
                                 "nvm = a1.nvm\n"
                                 "serial = 123\n"
                                 "temperature = 85\n"
                                 "[encoder a2]\n"
                                 "model = ocd-ib-k1\n"
                                 "bus = ring\n"
                                 "[encoder rs]\n"
                                 "model = s3684-rs485\n"
                                 "wire = pty:/tmp/enc1\n"
                                 "trace = /tmp/rs.vcd\n"
                                 "address = 0x41\n";

static void check_rig_and_shafts(const struct dg_plan *plan)
{
    assert_string_equal(plan->name, "bench");
    assert_string_equal(plan->file, FILE_NAME);
    assert_int_equal(plan->control_count, 2);
    assert_string_equal(plan->controls[0].where, "tcp:127.0.0.1:5025");
    assert_string_equal(plan->controls[1].where, "unix:sock");
    assert_int_equal(plan->shaft_count, 2);
    assert_string_equal(plan->shafts[0].motion, "60RPM");
    assert_int_equal(plan->shafts[0].driver, -1);
    assert_int_equal(plan->shafts[1].driver, 0);
    assert_int_equal(plan->shafts[1].ratio[0], -1);
    assert_int_equal(plan->shafts[1].ratio[1], 10);
}

static void check_wires(const struct dg_plan *plan)
{
    assert_int_equal(plan->wire_count, 2);
    assert_string_equal(plan->wires[0].name, "ring");
    assert_string_equal(plan->wires[0].where, "127.0.0.1:5020");
    assert_string_equal(plan->wires[0].trace, "ring.csv");
    assert_int_equal(plan->wires[0].settings.count, 1);
    assert_string_equal(plan->wires[0].settings.list[0].key, "cycle");
    assert_string_equal(plan->wires[0].settings.list[0].value, "2000");
    assert_int_equal(plan->wires[0].settings.list[0].line, 14);
    assert_string_equal(plan->wires[1].name, "rs");
    assert_string_equal(plan->wires[1].kind->name, "pty");
    assert_string_equal(plan->wires[1].where, "/tmp/enc1");
    assert_string_equal(plan->wires[1].trace, "/tmp/rs.vcd");
}

static void check_encoders(const struct dg_plan *plan)
{
    const struct dg_plan_encoder *a1 = &plan->encoders[0];
    assert_int_equal(plan->encoder_count, 3);
    assert_string_equal(a1->model->name, "ocd-ib-k3");
    assert_int_equal(a1->shaft, 1);
    assert_int_equal(a1->wire, 0);
    assert_string_equal(a1->nvm, "a1.nvm");
    assert_string_equal(a1->serial, "123");
    assert_int_equal(a1->address, DG_PLAN_AS_DELIVERED);
    assert_int_equal(a1->line, 15);
    assert_int_equal(a1->nvm_line, 19);
    assert_int_equal(a1->serial_line, 20);
    assert_int_equal(a1->settings.count, 1);
    assert_string_equal(a1->settings.list[0].key, "temperature");
    assert_string_equal(a1->settings.list[0].value, "85");
    assert_int_equal(plan->encoders[1].shaft, 0); /* the first one */
    assert_int_equal(plan->encoders[2].address, 0x41);
    assert_int_equal(plan->encoders[2].address_line, 29);
}

static void everything_is_read(void **state)
{
    struct dg_plan plan;
    (void)state;
    read_good(&plan, everything);
    check_rig_and_shafts(&plan);
    check_wires(&plan);
    check_encoders(&plan);
    lx_plan_free(&plan);
    assert_all_zero(&plan);
}

/* Line ends, byte order marks, indentation, colons: as other tools write such files. */
static void other_tools(void **state)
{
    struct dg_plan plan;
    (void)state;
    read_good(&plan, "\xEF\xBB\xBF[encoder a]\r\n"
                     "  model = f3668\r\n"
                     "\twire:slcan ; where the kernel has no CAN\r\n"
                     "\r\n"
                     "  # the end, without a line end\r\n"
                     "node=7");
    assert_string_equal(plan.name, "rig");
    assert_int_equal(plan.shaft_count, 1);
    assert_string_equal(plan.shafts[0].name, "main");
    assert_string_equal(plan.wires[0].kind->name, "slcan");
    assert_null(plan.wires[0].where);
    assert_int_equal(plan.encoders[0].address, 7);
    lx_plan_free(&plan);
}

static void files_lie_beside_the_rig_file(void **state)
{
    static const char text[] = "[rig]\ncontrol = unix:s\n"
                               "[shaft m]\nmotion = m.csv\n"
                               "[encoder a]\nmodel = s3684-rs485\nwire = pty:link\nnvm = a.nvm\n"
                               "trace = /abs/a.vcd\n";
    struct dg_plan plan;
    struct lx_error error;
    (void)state;
    write_bytes("sub/" FILE_NAME, text, strlen(text));
    assert_int_equal(lx_plan_read(&plan, "sub/" FILE_NAME, &error), 0);
    assert_string_equal(plan.controls[0].where, "unix:sub/s");
    assert_string_equal(plan.shafts[0].motion, "sub/m.csv");
    assert_string_equal(plan.wires[0].where, "sub/link");
    assert_string_equal(plan.wires[0].trace, "/abs/a.vcd");
    assert_string_equal(plan.encoders[0].nvm, "sub/a.nvm");
    lx_plan_free(&plan);
}

/* A shaft with 8 gears in front of it, as many as there may be. */
#define GEARS                                                                                      \
    "[shaft s0]\n[shaft s1]\ndriver=s0\n[shaft s2]\ndriver=s1\n[shaft s3]\ndriver=s2\n"            \
    "[shaft s4]\ndriver=s3\n[shaft s5]\ndriver=s4\n[shaft s6]\ndriver=s5\n"                        \
    "[shaft s7]\ndriver=s6\n[shaft s8]\ndriver=s7\n"
#define ENCODER "[encoder a]\nmodel = f3668\nwire = slcan\n"
#define ON_BUS(name) "[encoder " name "]\nmodel = f3668\nbus = b\n"
#define ON_SIM(name) "[encoder " name "]\nmodel = s3684-biss\nbus = b\n"
#define SLCAN_BUS "[bus b]\nwire = slcan\n"
#define AT_PORT(name, port)                                                                        \
    "[encoder " name "]\nmodel = ocd-ib-k3\nwire = modbus:127.0.0.1:" port "\n"
#define NO_RANGE(text) "6: node " text ": expected a node-ID in 1..127, or FIRST..LAST"
#define RATIO(text) "[shaft a]\n[shaft b]\ndriver = a\nratio = " text "\n"
#define NO_RATIO(text)                                                                             \
    "4: ratio: " text " is no ratio; expected TURNS:TURNS with whole numbers other than 0"
#define NO_NAME(text)                                                                              \
    "1: [" text "]: expected a name of 1 to 32 letters, digits, _ and -, as in [encoder a1]"
#define NO_ENCODERS " without encoders; expected [encoder NAME] with model = MODEL and wire = KIND"
/* All there are, see message_of(). */
#define MODELS "(models)"
#define WIRES "(wires)" /* of CAN */
#define A32 "abcdefghijklmnopqrstuvwxyz012345"

/* A file, and what follows "rig.ini:". */
static const struct {
    const char *text;
    const char *message;
} bad[] = {
    {"", NO_ENCODERS},
    {"; nothing\n", NO_ENCODERS},
    {"[shaft a]\n", NO_ENCODERS},
    {"model = f3668\n",
     "1: model: stands before the first section; expected [rig], [model NAME], [shaft NAME], [bus "
     "NAME] or [encoder NAME]"},
    {"\n[foo]\n",
     "2: [foo]: no such section; expected [rig], [model NAME], [shaft NAME], [bus NAME] or "
     "[encoder NAME]"},
    {"[a\033[31m\177b]\n", /* what would paint the terminal */
     "1: [a?[31m?b]: no such section; expected [rig], [model NAME], [shaft NAME], [bus NAME] or "
     "[encoder NAME]"},
    {"[]\n",
     "1: []: no such section; expected [rig], [model NAME], [shaft NAME], [bus NAME] or [encoder "
     "NAME]"},
    {"[encoder]\n", NO_NAME("encoder")},
    {"[encoder a b]\n", NO_NAME("encoder a ...")},
    {"[encoder a.b]\n", NO_NAME("encoder a.b")},
    {"[encoder " A32 "6]\n", NO_NAME("encoder " A32 "6")},
    {"[rig bench]\n", "1: [rig bench]: has no name; expected [rig]"},
    {"[encoder a\nmodel=f3668\n",
     "1: '[encoder a' is no section; expected [KIND NAME] on a separate line"},
    {"[encoder a] wire = can\n",
     "1: '[encoder a] wire = can' is no section; expected [KIND NAME] on a separate line"},
    {"[encoder a]\nmodel ; = f3668\n",
     "2: 'model ; = f3668' is neither [SECTION] nor KEY = VALUE; expected one of them"},
    {ENCODER "so be it",
     "4: 'so be it' is neither [SECTION] nor KEY = VALUE; expected one of them"},
    {"[rig]\ncolour = red\n",
     "2: colour: no key of [rig]; expected name, control, files, threads, memory or include"},
    {"[rig]\nname = a b\n",
     "2: name: a b is not a valid name; expected 1 to 32 letters, digits, _ and -"},
    {"[rig]\nname = a\n[rig]\nname = b\n",
     "4: name: the rig is called a already; expected one name"},
    {"[rig]\nname =\n", "2: name: empty; expected name = VALUE"},
    {"[rig]\ncontrol = tcp\n", "2: control: tcp: expected unix:PATH or tcp:HOST:PORT"},
    {"[rig]\ncontrol = unix:a\ncontrol = unix:b\ncontrol = unix:c\ncontrol = unix:d\ncontrol = unix:e\n",
     "6: control: one more than 4; expected fewer"},
    {"[shaft a]\nmotion = fast\n",
     "2: motion fast: 'fast' is not a number with a unit (DEG REV RPM S MS); valid: 0, 90DEG, 2.5REV, 60RPM, sine:90DEG,2S, ramp:3000RPM,1S[,HOLD] or FILE.csv"},
    {"[shaft a]\nmotion = ramp:3000RPM,0S\n",
     "2: motion ramp:3000RPM,0S: out of range; a ramp takes above 0 to 3600S, a sine has up to 256REV and above 0 to 86400S"},
    {"[shaft a]\n[shaft A]\n", "2: [shaft A]: line 1 has the name already; expected another name"},
    {"[shaft a]\ndriver = b\n",
     "2: driver: no shaft b so far; expected the NAME of a [shaft] above"},
    {"[shaft a]\ndriver = a\n",
     "2: driver: no shaft a so far; expected the NAME of a [shaft] above"},
    {"[shaft a]\nratio = 1:2\n",
     "2: ratio: without a driver; expected driver = NAME of a [shaft] above"},
    {"[shaft a]\n[shaft b]\nmotion = 60RPM\ndriver = a\n",
     "3: motion: the driver in line 4 turns this shaft; expected one of them"},
    {RATIO("0:1"), NO_RATIO("0:1")},
    {RATIO("1:0"), NO_RATIO("1:0")},
    {RATIO("1"), NO_RATIO("1")},
    {RATIO("1.5:1"), NO_RATIO("1.5:1")},
    {RATIO("1:2:3"), NO_RATIO("1:2:3")},
    {RATIO("x:1"), NO_RATIO("x:1")},
    {RATIO("2147483648:1"), NO_RATIO("2147483648:1")},
    {RATIO("1:-2147483648"), NO_RATIO("1:-2147483648")},
    {RATIO(":"), NO_RATIO(":")},
    {RATIO("1:"), NO_RATIO("1:")},
    {GEARS "[shaft s9]\ndriver = s8\n",
     "19: driver: 8 gears are between s8 and what drives it; expected a shaft with fewer"},
    {"[shaft a]\nspeed = 1\n", "2: speed: no key of [shaft]; expected motion, driver or ratio"},
    {"[shaft a]\nmotion = 60RPM\nmotion = 70RPM\n",
     "3: motion: given in line 2 already; expected one of them"},
    {"[bus b]\n", "1: [bus b]: without a wire; expected a wire, for example wire = pty"},
    {"[bus b]\nwire = slcan:/x\n",
     "2: wire: slcan:/x is a kind and an address; expected wire = slcan and address = /x in a line "
     "each"},
    {"[shaft a]\nmotion = 90\n",
     "2: motion 90: '90' has no unit; expected 90DEG or 90RPM, for example"},
    {"[shaft a]\nmotion = sine:90\n",
     "2: motion sine:90: '90' has no unit; expected an angle such as 90DEG or 2.5REV"},
    {ENCODER " = 5\n", "4: no key in front of '= 5'; expected KEY = VALUE"},
    {"[encoder a]\nmodell = f3668\nwire = slcan\n",
     "2: modell: no such key; expected model = f3668"},
    {"[bus b]\nwire = can\n", "1: address: can needs an address; expected IFNAME"},
    {"[bus b]\nwire = sim\naddress = x\n", "3: address: sim has no address; expected no address"},
    {"[bus b]\nwire = pty\n",
     "1: [bus b]: without encoders; expected bus = b in an [encoder NAME], or no such bus"},
    {"[bus b]\nwire = pty\ncycle = 1000\n",
     "3: cycle: no key of a pty bus; expected wire, address or trace"},
    {"[bus b]\nwire = modbus\ncolour = 1\n",
     "3: colour: no key of a modbus bus; expected wire, address, trace, cycle, tear or break_at"},
    {"[bus b]\nwire = slcan\ncycle = 1000\n",
     "3: cycle: no key of a slcan bus; expected wire, address, trace or pace"},
    {"[bus b]\nwire = pty\naddress = x\n[bus c]\nwire = slcan\naddress = x\n",
     "6: address: x is the wire in line 1 already; expected another address"},
    {"[encoder a]\nmodel = s3684-rs485\nwire = pty:x\n"
     "[encoder b]\nmodel = s3684-rs485\nwire = pty:x\n",
     "6: wire: x is the wire in line 1 already; expected another address, or [bus NAME] with wire "
     "= pty and address = x, and bus = NAME in both encoders"},
    {"[encoder a]\nmodel = s3684-rs485\nwire = pty:x\n"
     "[encoder b]\nmodel = f3668\nwire = slcan:x\n",
     "6: wire: x is the wire in line 1 already; expected another address"},
    {AT_PORT("a", "05") AT_PORT("b", "05"),
     "6: wire: 127.0.0.1:05 is the wire in line 1 already; expected another address, or [bus NAME] "
     "with wire = modbus and address = 127.0.0.1:05, and bus = NAME in both encoders"},
    {"[bus b]\nwire = modbus\n[bus c]\nwire = modbus\n",
     "3: address: 127.0.0.1:5020 is the wire in line 1 already; expected another address"},
    {"[bus b]\nwire = pty\ntrace = x.vcd\n[bus c]\nwire = pty\ntrace = x.vcd\n",
     "6: trace: x.vcd is of the wire in line 1 already; expected another file"},
    {"[bus b]\nwire = pty\n[bus B]\nwire = pty\n",
     "3: [bus B]: line 1 has the name already; expected another name"},
    {"[encoder a]\nwire = pty\n",
     "1: [encoder a]: without a model; expected model = MODEL, one of: " MODELS},
    {"[encoder a]\nmodel = s3685\nwire = pty\n",
     "2: model: s3685 is unknown; expected one of: " MODELS},
    {"[encoder a]\nmodel = f3668\n",
     "1: [encoder a]: without a wire; expected bus = NAME of a [bus] above, or wire = KIND or "
     "KIND:ADDRESS"},
    {"[bus b]\nwire = slcan\n" ENCODER "bus = b\n",
     "6: [encoder a]: a bus and a wire; expected bus = NAME of a [bus] above, or wire = KIND or "
     "KIND:ADDRESS"},
    {ON_BUS("a"), "3: bus: no bus b so far; expected the NAME of a [bus] above"},
    {ENCODER "[encoder b]\nmodel = f3668\nbus = a\n",
     "6: bus: no bus a so far; expected the NAME of a [bus] above"},
    {"[encoder a]\nmodel = f3668\nwire = pty\n",
     "3: wire: pty is no wire of f3668; expected " WIRES},
    {"[encoder a]\nmodel = f3668\nwire = can\n", "3: wire: can needs an address; expected IFNAME"},
    {"[bus b]\nwire = pty\n" ON_BUS("a"), "5: bus: pty is no wire of f3668; expected " WIRES},
    {"[bus b]\nwire = sim\n" ON_SIM("a") "[encoder c]\nmodel = ssi-25\nbus = b\n",
     "8: bus: b has encoders of another protocol; expected another bus"},
    {ENCODER "[encoder A]\n", "4: [encoder A]: line 1 has the name already; expected another name"},
    {"[bus A]\nwire = pty\n" ENCODER,
     "3: [encoder a]: line 1 has the name already; expected another name"},
    {ENCODER "node = 200\n", "4: node 200: expected a node-ID in 1..127"},
    {ENCODER "node = 0\n", "4: node 0: expected a node-ID in 1..127"},
    {ENCODER "address = 0x41\n", "4: address: f3668 has none; expected node = N"},
    {SLCAN_BUS ON_BUS("a") "address = 1..2\n", "6: address: f3668 has none; expected node = N"},
    {SLCAN_BUS ON_BUS("a") "node = 0..2\n", NO_RANGE("0..2")},
    {SLCAN_BUS ON_BUS("a") "node = 1..128\n", NO_RANGE("1..128")},
    {SLCAN_BUS ON_BUS("a") "node = 2..1\n", NO_RANGE("2..1")},
    {SLCAN_BUS ON_BUS("a") "node = ..2\n", NO_RANGE("..2")},
    {SLCAN_BUS ON_BUS("a") "node = 1..\n", NO_RANGE("1..")},
    {SLCAN_BUS ON_BUS("a") "node = 00000000000000000001..2\n", NO_RANGE("00000000000000000001..2")},
    {SLCAN_BUS ON_BUS(A32) "node = 9..10\n",
     "3: [encoder " A32 "]: " A32 "-9 is too long for a name; expected a shorter name"},
    {SLCAN_BUS ON_BUS("a") "node = 1..3\n" ON_BUS("a-2") "node = 9\n",
     "7: [encoder a-2]: line 3 has the name already; expected another name"},
    {SLCAN_BUS ON_BUS("a") "node = 1..3\n" ON_BUS("c") "node = 3..4\n",
     "10: node: 3 is node of [encoder a-3] already; expected node = N with another one"},
    {ENCODER "node = 1..2\n",
     "3: wire: several encoders have no wire of their own; expected bus = NAME of a [bus] above"},
    {"[encoder a]\nmodel = ocd-ib-k3\nwire = modbus\nnode = 5\n",
     "4: node: ocd-ib-k3 has none; the order of the encoders on its wire decides"},
    {"[encoder a]\nmodel = s3684-rs485\nwire = pty\naddress = 0x60\n",
     "4: address 0x60: expected an RS485 address in 0x40..0x5F"},
    {"[bus b]\nwire = slcan\n" ON_BUS("a") ON_BUS("c"),
     "6: node: as delivered 63 is node of [encoder a] already; expected node = N with another one"},
    {"[bus b]\nwire = slcan\n" ON_BUS("a") "node = 5\n" ON_BUS("c") "node = 05h\n",
     "10: node: 05h is node of [encoder a] already; expected node = N with another one"},
    {ENCODER "shaft = x\n", "4: shaft: no shaft x so far; expected the NAME of a [shaft] above"},
    {ENCODER "[shaft x]\n",
     "4: [shaft x]: [encoder a] above has done without a shaft; expected shafts before all encoders"},
    {ENCODER "nvm = x\n[encoder b]\nmodel = f3668\nwire = slcan\nnvm = x\n",
     "8: nvm: x is of [encoder a] already; expected another file"},
    {"[bus b]\nwire = slcan\n" ON_BUS("a") "trace = x.log\n",
     "6: trace: a bus has one for all its encoders; expected trace = FILE in [bus b]"},
    {"[bus b]\nwire = modbus\n[encoder a]\nmodel = ocd-ib-k3\nbus = b\ncycle = 250\n",
     "6: cycle: a bus has one for all its encoders; expected cycle = 250 in [bus b]"},
    {ENCODER "serial =\n", "4: serial: empty; expected serial = VALUE"},
    {"[bus b]\nwire = sim\n" ON_SIM("a") ON_SIM("c") ON_SIM("d") ON_SIM("e") ON_SIM("f") ON_SIM("g")
         ON_SIM("h") ON_SIM("i") ON_SIM("j"),
     "29: bus: b has 8 encoders already; expected no more encoders"},
};

/* The last of what is refused when it goes one further; a free port anybody may have. */
static const char *const edges[] = {
    SLCAN_BUS ON_BUS("a") "node = 5..5\n",
    SLCAN_BUS ON_BUS("a") "node = 00000000000001..2\n",
    SLCAN_BUS ON_BUS("abcdefghijklmnopqrstuvwxyz0123") "node = 8..9\n",
    AT_PORT("a", "0") AT_PORT("b", "0"),
    AT_PORT("a", "0,open") AT_PORT("b", "0,open"),
    "[encoder " A32 "]\nmodel = f3668\nwire = slcan\n",
    "[rig]\nname = " A32
    "\ncontrol = unix:a\ncontrol = unix:b\ncontrol = unix:c\ncontrol = unix:d\n" ENCODER,
    GEARS ENCODER,
    RATIO("2147483647:-2147483647") ENCODER,
    RATIO("-2147483647:1") ENCODER,
    "[bus b]\nwire = sim\n" ON_SIM("a") ON_SIM("c") ON_SIM("d") ON_SIM("e") ON_SIM("f") ON_SIM("g")
        ON_SIM("h") ON_SIM("i"),
    "[bus b]\nwire = silkit\naddress = silkit://h:1,n\n" ON_SIM("a"),
};

static void what_is_right_up_to_its_edge(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(edges); i++) {
        struct dg_plan plan;
        read_good(&plan, edges[i]);
        lx_plan_free(&plan);
    }
}

/* The sign is that of the shaft that is driven. */
static void a_ratio_has_one_sign(void **state)
{
    struct dg_plan plan;
    (void)state;
    read_good(&plan, RATIO("3:-7") "[shaft c]\ndriver = a\nratio = -3:-7\n" ENCODER);
    assert_true(plan.shafts[1].ratio[0] == -3 && plan.shafts[1].ratio[1] == 7);
    assert_true(plan.shafts[2].ratio[0] == 3 && plan.shafts[2].ratio[1] == 7);
    lx_plan_free(&plan);
}

/* A message as it has to be: with the models by name where it says MODELS, likewise WIRES. */
static struct lx_words message_of(const char *file, const char *text)
{
    const char *models = strstr(text, MODELS);
    const char *at = models == NULL ? strstr(text, WIRES) : models;
    const size_t n = at == NULL ? strlen(text) : (size_t)(at - text);
    struct lx_words names = {""};
    struct lx_words message = {""};
    lx_stack_models(NULL, &names);
    const char *wires = at == NULL ? "" : list_wires(DG_PLAN_CARRIES(FRAMES), " or ");
    lx_words_add(&message, "%s%.*s%s", file, (int)n, text, models == NULL ? wires : names.text + 1);
    return message;
}

static void what_is_wrong_and_where(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(bad); i++) {
        struct dg_plan plan;
        struct lx_error error = {.right = ""};
        write_bytes(FILE_NAME, bad[i].text, strlen(bad[i].text));
        assert_int_equal(lx_plan_read(&plan, FILE_NAME, &error), -1);
        assert_string_equal(lx_error_line(&error).text,
                            message_of(FILE_NAME ":", bad[i].message).text);
        assert_all_zero(&plan);
    }
}

static void assert_refused(const char *file, const char *text, size_t n, const char *message)
{
    struct dg_plan plan;
    struct lx_error error = {.right = ""};
    if (text != NULL) {
        write_bytes(file, text, n);
    }
    assert_int_equal(lx_plan_read(&plan, file, &error), -1);
    assert_string_equal(lx_error_line(&error).text, message_of("", message).text);
    assert_all_zero(&plan);
}

static void lines_that_are_none(void **state)
{
    static const char limit[] = FILE_NAME
        ":2: more than 198 characters, or no text at all; expected a shorter line of text";
    static const char zero[] = "[encoder a]\nmodel = \0f3668\nwire = slcan\n";
    char text[300];
    (void)state;
    assert_refused(FILE_NAME, zero, sizeof zero - 1, limit);
    for (int n = 170; n <= 192; n++) { /* "nvm = " and so many characters */
        const bool fits = strlen("nvm = ") + (size_t)n <= 198;
        const int length = snprintf(text, sizeof text, "[encoder a]\nnvm = %0*d\n", n, 0);
        assert_true(fits);
        assert_refused(FILE_NAME, text, (size_t)length,
                       FILE_NAME ":1: [encoder a]: without a model; expected model = MODEL, one "
                                 "of: " MODELS);
    }
    const int length = snprintf(text, sizeof text, "[encoder a]\nnvm = %0*d\n", 193, 0);
    assert_refused(FILE_NAME, text, (size_t)length, limit);
}

static void files_that_are_none(void **state)
{
    (void)state;
    assert_refused("none.ini", NULL, 0, "none.ini: cannot open: No such file or directory");
    assert_refused("sub", NULL, 0, "sub: cannot read: Is a directory");
    assert_refused("/dev/zero", NULL, 0, "/dev/zero: cannot read: File too large");
}

/* Beside the rig file or below it, and never by a link. */
/* qemu-user has no openat2(): nothing is included then, rather than from anywhere. */
static bool kernel_confines(void)
{
    const struct open_how how = {.flags = O_PATH | O_CLOEXEC};
    const long fd = syscall(SYS_openat2, AT_FDCWD, ".", &how, sizeof how);
    if (fd >= 0) {
        (void)close((int)fd);
    }
    return fd >= 0 || errno != ENOSYS;
}

static void included_files(void **state)
{
    static const char bus[] = "[bus b]\nwire = slcan\naddress = hub\n";
    static const char both[] = "[bus b]\nwire = pty:x\n";
    struct dg_plan plan;
    (void)state;
    write_bytes("sub/" FILE_NAME, bus, strlen(bus));
    if (!kernel_confines()) {
        static const char include[] = "[rig]\ninclude = sub/" FILE_NAME "\n";
        assert_refused(FILE_NAME, include, strlen(include),
                       FILE_NAME ":2: include: sub/" FILE_NAME ": Function not implemented");
        return;
    }
    assert_int_equal(symlink("sub/" FILE_NAME, "link.ini"), 0);
    read_good(&plan, "[rig]\ninclude = sub/" FILE_NAME "\n" ON_BUS("a"));
    assert_string_equal(plan.wires[0].where, "sub/hub");
    struct lx_error error = {.right = ""};
    assert_int_equal(lx_plan_refuse_wire(&plan, &plan.wires[0], &error), -1);
    assert_string_equal(lx_error_line(&error).text,
                        FILE_NAME ":2: sub/" FILE_NAME ":3: slcan:sub/hub: ");
    lx_plan_free(&plan);
    static const char by_link[] = "[rig]\ninclude = link.ini\n" ON_BUS("a");
    assert_refused(FILE_NAME, by_link, strlen(by_link),
                   FILE_NAME
                   ":2: include: link.ini: not in the folder for files; expected a name below it");
    static const char none[] = "[rig]\ninclude = sub/none.ini\n";
    assert_refused(FILE_NAME, none, strlen(none),
                   FILE_NAME ":2: include: sub/none.ini: No such file or directory");
    write_bytes("sub/" FILE_NAME, both, strlen(both));
    static const char text[] = "[rig]\ninclude = sub/" FILE_NAME "\n";
    assert_refused(FILE_NAME, text, strlen(text),
                   FILE_NAME ":2: sub/" FILE_NAME
                             ":2: wire: pty:x is a kind and an address; expected wire = pty and "
                             "address = x in a line each");
    assert_int_equal(unlink("link.ini"), 0);
}

/* Empty files are files, too. */
static void so_many_files_are_included(void **state)
{
    enum { MOST = 4096 };
    static const char rig[] = "[rig]\n";
    static const char one[] = "include = sub/empty\n";
    static const char end[] = SLCAN_BUS ON_BUS("a");
    const size_t n = strlen(rig) + MOST * strlen(one);
    char *text = malloc(n + sizeof end);
    struct dg_plan plan;
    (void)state;
    assert_non_null(text);
    memcpy(text, rig, strlen(rig));
    for (size_t i = 0; i < MOST; i++) {
        memcpy(text + strlen(rig) + i * strlen(one), one, strlen(one));
    }
    if (kernel_confines()) {
        write_bytes("sub/empty", "", 0);
        memcpy(text + n, end, sizeof end);
        read_good(&plan, text);
        lx_plan_free(&plan);
        memcpy(text + n, one, strlen(one));
        assert_refused(FILE_NAME, text, n + strlen(one),
                       FILE_NAME
                       ":4098: include: one more than 4096 included files; expected fewer");
        assert_int_equal(unlink("sub/empty"), 0);
    }
    free(text);
}

/* As many as there is memory for, each of them known by its name. */
static void many(void **state)
{
    enum { COUNT = 3000 };
    char *text = malloc((size_t)COUNT * 160);
    struct dg_plan plan;
    struct lx_error error = {.right = ""};
    size_t n = 0;
    (void)state;
    assert_non_null(text);
    for (unsigned i = 0; i < COUNT; i++) {
        n += (size_t)snprintf(text + n, 160, "[shaft s%u]\n", i);
    }
    for (unsigned i = 0; i < COUNT; i++) {
        n += (size_t)snprintf(text + n, 160,
                              "[encoder e%u]\nmodel = s3684-rs485\nwire = pty:l%u\nnvm = n%u\n"
                              "shaft = S%u\n",
                              i, i, i, COUNT - 1u - i);
    }
    write_bytes(FILE_NAME, text, n);
    free(text);
    assert_int_equal(lx_plan_read(&plan, FILE_NAME, &error), 0);
    assert_int_equal(plan.encoder_count, COUNT);
    for (unsigned i = 0; i < COUNT; i++) {
        char name[16];
        (void)snprintf(name, sizeof name, "E%u", i);
        assert_int_equal(plan.encoders[i].shaft, COUNT - 1u - i);
        assert_int_equal(dg_plan_find_wire(&plan, name), i);
    }
    lx_plan_free(&plan);
}

/* One section, a number each: everything else is the same, what counts counts up. */
static void one_section_for_many(void **state)
{
    struct dg_plan plan;
    char text[64];
    (void)state;
    read_good(&plan, SLCAN_BUS "[encoder a]\nmodel = f3668\nbus = b\nnode = 2..127\n"
                               "serial = 1000\nnvm = a.nvm\ntemperature = 85\n"
                               "[bus l]\nwire = pty\n[encoder c]\nmodel = s3684-rs485\n"
                               "bus = l\naddress = 0x40..5Fh\n");
    assert_int_equal(plan.encoder_count, 126 + 32);
    assert_int_equal(plan.wire_count, 2);
    for (int i = 0; i < 126; i++) {
        const struct dg_plan_encoder *encoder = &plan.encoders[i];
        (void)snprintf(text, sizeof text, "a-%d", 2 + i);
        assert_string_equal(encoder->name, text);
        assert_int_equal(encoder->address, 2 + i);
        (void)snprintf(text, sizeof text, "%d", 1000 + i);
        assert_string_equal(encoder->serial, text);
        (void)snprintf(text, sizeof text, "a.nvm.%d", 2 + i);
        assert_string_equal(encoder->nvm, text);
        assert_int_equal(encoder->settings.count, 1);
        assert_int_equal(encoder->line, 3);
    }
    assert_string_equal(plan.encoders[126].name, "c-0x40");
    assert_int_equal(plan.encoders[157].address, 0x5F);
    lx_plan_free(&plan);
}

/* From the command line there are no lines. */
static void without_a_file(void **state)
{
    struct dg_plan plan;
    struct lx_error error = {.right = ""};
    (void)state;
    plan_rig_begin(&plan, "w", dg_plan_find_kind("can", 3), "vcan0");
    assert_int_equal(dg_plan_add_shaft(&plan, "main", "60RPM"), 1);
    for (int i = 0; i < 9; i++) {
        assert_int_equal(dg_plan_add_encoder(&plan, "e", dg_device_find("f3668"), 0, 0), i);
    }
    assert_int_equal(lx_plan_add_assignment(&plan.encoders[8].settings, "a=b=c", 0, &error), 0);
    assert_string_equal(plan.encoders[8].settings.list[0].key, "a");
    assert_string_equal(plan.encoders[8].settings.list[0].value, "b=c");
    assert_int_equal(lx_plan_add_assignment(&plan.encoders[8].settings, "pace", 0, &error), -1);
    assert_string_equal(lx_error_line(&error).text, "pace: expected KEY=VALUE");
    assert_int_equal(lx_plan_refuse_key(&plan, "k", 7, &error), -1);
    assert_string_equal(lx_error_line(&error).text, "pace: expected KEY=VALUE");
    plan_rig_free(&plan);
    assert_all_zero(&plan);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(everything_is_read),
        cmocka_unit_test(other_tools),
        cmocka_unit_test(files_lie_beside_the_rig_file),
        cmocka_unit_test(what_is_wrong_and_where),
        cmocka_unit_test(what_is_right_up_to_its_edge),
        cmocka_unit_test(a_ratio_has_one_sign),
        cmocka_unit_test(lines_that_are_none),
        cmocka_unit_test(files_that_are_none),
        cmocka_unit_test(included_files),
        cmocka_unit_test(so_many_files_are_included),
        cmocka_unit_test(many),
        cmocka_unit_test(one_section_for_many),
        cmocka_unit_test(without_a_file),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
