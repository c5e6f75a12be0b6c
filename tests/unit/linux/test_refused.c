/* SPDX-License-Identifier: MIT */
/*
 * Rig files that are read without a complaint and cannot be opened: which line of which file says
 * why, whether it is the plan or the world, and that the folder is as it was before.
 */
#define _GNU_SOURCE
#include <dirent.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <systemd/sd-event.h>
#include <unistd.h>

#include <cmocka.h>

#include "descriptors.h"
#include "rig.h"
#include "timer.h"

#define LINE "[encoder e]\nmodel = s3684-rs485\nwire = pty\n"
#define BEYOND "beyond loopback, where anybody could "

/* clang-format off */
static const struct {
    enum lx_rig_result result;
    const char *rig;
    const char *line;
} rows[] = {
    {LX_RIG_WORLD, "[encoder e]\nmodel = s3684-rs485\nwire = pty:folder\n",
     "rig.ini:3: pty:folder: exists and is not a link to a pty; remove it or give another name"},
    {LX_RIG_WORLD, "[encoder e]\nmodel = s3684-rs485\nwire = pty:no/link\n",
     "rig.ini:3: pty:no/link: cannot make the link: No such file or directory"},
    {LX_RIG_WORLD, "[encoder e]\nmodel = s3684-rs485\nwire = tty:no\n",
     "rig.ini:3: tty:no: cannot use it at 9600 Bd 8E1: No such file or directory"},
    {LX_RIG_WORLD, "[encoder e]\nmodel = s3684-rs485\nwire = tty:text\n",
     "rig.ini:3: tty:text: not a serial port; expected a serial port such as /dev/ttyUSB0"},
    {LX_RIG_WORLD, "[encoder e]\nmodel = s3684-rs485\nwire = rs485:tcp:0.0.0.0:0\n",
     "rig.ini:3: rs485:tcp:0.0.0.0:0: " BEYOND "connect; use 0.0.0.0:0,open if you want that"},
    {LX_RIG_WORLD, "[encoder e]\nmodel = f3668\nwire = slcan:tcp:[::]:0\n",
     "rig.ini:3: slcan:tcp:[::]:0: " BEYOND "connect; use [::]:0,open if you want that"},
    {LX_RIG_WORLD, "[bus b]\nwire = socketcand\naddress = 0.0.0.0:0\n[encoder e]\nmodel = f3668\nbus = b\n",
     "rig.ini:3: socketcand:0.0.0.0:0: " BEYOND "connect; use 0.0.0.0:0,open if you want that"},
    {LX_RIG_WORLD, "[encoder e]\nmodel = ocd-ib-k3\nwire = modbus:0.0.0.0:0\n",
     "rig.ini:3: modbus:0.0.0.0:0: " BEYOND "connect; use 0.0.0.0:0,open if you want that"},
    {LX_RIG_PLAN, "[encoder e]\nmodel = f3668\nwire = slcan:tcp:1\n",
     "rig.ini:3: slcan:tcp:1: expected LINK, tcp:HOST:PORT or tcp:HOST:PORT,open"},
    {LX_RIG_PLAN, "[bus b]\nwire = rs485\naddress = 0x40\n[encoder e]\nmodel = s3684-rs485\nbus = b\n",
     "rig.ini:3: rs485:0x40: expected rfc2217:HOST:PORT or tcp:HOST:PORT, with or without ,open"},
    {LX_RIG_WORLD, LINE "nvm = no/such\n", "rig.ini:4: nvm: no/such: cannot create: No such file or directory"},
    {LX_RIG_WORLD, LINE "nvm = folder\n", "rig.ini:4: nvm: folder: cannot open: Is a directory"},
    {LX_RIG_WORLD, LINE "nvm = text\n",
     "rig.ini:4: nvm: text: something else, no image of this kind of encoder; give a file made by drehgeber, or the "
     "name of a new one"},
    {LX_RIG_WORLD, "[encoder e]\nmodel = ocd-ib-k3\nwire = modbus:127.0.0.1:0\nnvm = text\n",
     "rig.ini:4: nvm: text: something else, no image of this kind of encoder; give a file made by drehgeber, or the "
     "name of a new one"},
    {LX_RIG_WORLD, LINE "nvm = new\ntrace = no/such.vcd\n",
     "rig.ini:5: trace: no/such.vcd: cannot open: No such file or directory"},
    {LX_RIG_PLAN, LINE "nvm = new\ntrace = such.log\n",
     "rig.ini:5: trace: such.log: the name of a trace of RS485 ends in .vcd"},
    {LX_RIG_WORLD, "[shaft s]\nmotion = no.csv\n" LINE,
     "rig.ini:2: motion: no.csv: cannot open: No such file or directory"},
    {LX_RIG_WORLD, "[shaft s]\nmotion = bad.csv\n" LINE,
     "rig.ini:2: motion: bad.csv:2: the angle is decimal degrees within +-6000000000, not 'x'"},
    {LX_RIG_WORLD, LINE "temperature = no.csv\n",
     "rig.ini:4: temperature=no.csv: no.csv: cannot open: No such file or directory"},
    {LX_RIG_WORLD, LINE "led_current_ua = 1\ntemperature = bad.csv\n",
     "rig.ini:5: temperature=bad.csv: bad.csv:2: the value is a number in -273..1000 degC, not 'x'"},
    {LX_RIG_PLAN, LINE "temperature = one.csv,LOOP\n",
     "rig.ini:4: temperature=one.csv,LOOP: a loop needs a time above 0"},
    {LX_RIG_PLAN, LINE "temperature = warm\n",
     "rig.ini:4: temperature=warm: expected a number in -273..1000 degC with at most 3 decimals"},
    {LX_RIG_PLAN, LINE "serial = x\n", "rig.ini:4: serial x: expected 1 to 9 digits"},
    {LX_RIG_PLAN, "[encoder e]\nmodel = ssi-25\nwire = sim\nserial = 5\n",
     "rig.ini:4: serial 5: ssi-25 has none; leave it out"},
    {LX_RIG_PLAN, "[bus b]\nwire = sim\nclock_hz = 1\n[encoder e]\nmodel = s3684-biss\nbus = b\n",
     "rig.ini:3: clock_hz=1: expected a number in 50000..10000000 Hz"},
    {LX_RIG_PLAN, "[encoder e]\nmodel = s3684-biss\nwire = sim\nbusy_us = 1\ntimeout_us = 13\n",
     "rig.ini:5: timeout_us: the simulated wire has the encoder's own timeout; only with gpio"},
    {LX_RIG_PLAN, LINE "memory = 100\nimplemented = 99\n",
     "rig.ini:1: implemented is 99; expected 100..128, or 0: as memory"},
    {LX_RIG_PLAN, LINE "periods = 4096\nsteps = 4097\n",
     "rig.ini:1: periods x steps is 16781312; expected at most 16777216"},
    {LX_RIG_PLAN, LINE "turns = 65537\n",
     "rig.ini:1: turns x periods x steps is 4295032832; expected at most 4294967296"},
    {LX_RIG_PLAN, "[encoder e]\nmodel = s3684-biss\nwire = sim\nmt = 32\nst = 32\n",
     "rig.ini:1: mt 32 and st 32; expected at most 49 together"},
    {LX_RIG_PLAN, "[encoder e]\nmodel = ssi-25\nwire = sim\nclock_hz = 50002\nmonoflop_us = 20\n",
     "rig.ini:4: clock_hz=50002: its period, 20000 ns, ends the word, as the monoflop time of 20000 ns is over; "
     "expected clock_hz from 50003 or monoflop_us from 21 on"},
    {LX_RIG_PLAN, "[encoder e]\nmodel = ssi-25\nwire = sim\nclock_hz = 50000\nmonoflop_us = 20\n",
     "rig.ini:4: clock_hz=50000: its period, 20000 ns, ends the word, as the monoflop time of 20000 ns is over; "
     "expected clock_hz from 50003 or monoflop_us from 21 on"},
    {LX_RIG_PLAN, "[encoder e]\nmodel = ssi-25\nwire = sim\nnvm = new\n",
     "rig.ini:4: nvm: ssi-25 has no EEPROM; leave it out"},
    {LX_RIG_WORLD, "[encoder e]\nmodel = ocd-ib-k1\nwire = modbus:127.0.0.1:0\nnvm = new\n",
     "rig.ini:4: nvm new: K1 and K2 have no EEPROM; leave it out, or use a K3"},
    {LX_RIG_WORLD, "[encoder e]\nmodel = ocd-ib-k1\nwire = modbus:127.0.0.1:0\nsteps = 1\nsteps_minus_one = 1\n",
     "rig.ini:3: device 0: these factory figures make no encoder; a K1 has at most 65536 steps, one with "
     "steps_minus_one at least 2"},
    {LX_RIG_WORLD, LINE "trace = such.vcd\nnvm = old.vcd\n",
     "rig.ini:5: nvm: old.vcd: something else, no image of this kind of encoder; give a file made by drehgeber, or "
     "the name of a new one"},
    {LX_RIG_WORLD, "[rig]\nfiles = no\n" LINE,
     "rig.ini:2: files: no: not a folder for files: No such file or directory"},
    {LX_RIG_WORLD, "[rig]\nfiles = text\n" LINE, "rig.ini:2: files: text: not a folder for files: Not a directory"},
    {LX_RIG_WORLD, "[rig]\ncontrol = unix:sock\ncontrol = unix:no/sock\n" LINE "nvm = new\ntrace = old.vcd\n",
     "rig.ini:3: control: unix:no/sock: cannot listen there: No such file or directory"},
    {LX_RIG_WORLD, "[rig]\ncontrol = unix:folder\n" LINE "trace = new.vcd\n",
     "rig.ini:2: control: unix:folder: exists and is no socket; remove it or give another name"},
    {LX_RIG_WORLD, "[rig]\ncontrol = tcp:0.0.0.0:0\n" LINE,
     "rig.ini:2: control: tcp:0.0.0.0:0: " BEYOND "control it; use tcp:0.0.0.0:0,open if you want that"},
    {LX_RIG_WORLD, "[rig]\ncontrol = tcp:127.0.0.1:0,token=no\n" LINE,
     "rig.ini:2: control: no: cannot open the token: No such file or directory"},
    {LX_RIG_WORLD, "[rig]\ncontrol = tcp:127.0.0.1:0,token=open\n" LINE,
     "rig.ini:2: control: open: others may read this token; run chmod 600"},
    {LX_RIG_WORLD, "[rig]\ncontrol = tcp:127.0.0.1:0,token=text\n" LINE,
     "rig.ini:2: control: text: no token; expected one line of 16 to 128 printable characters "
     "without blanks and quotes"},
};

static const struct {
    const char *name;
    const char *text;
    mode_t mode;
} files[] = {
    {"text",    "short\n",        0600},
    {"open",    "0123456789abcdef\n", 0644},
    {"bad.csv", "0,0\n1,x\n",     0600},
    {"one.csv", "0,20\n",         0600},
    {"old.vcd", "somebody's\n",   0600},
};
/* clang-format on */

static char folder[] = "/tmp/test_refused.XXXXXX";

static void write_file(const char *name, const char *text, mode_t mode)
{
    FILE *file = fopen(name, "w");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
    assert_int_equal(chmod(name, mode), 0);
}

static int make_folder(void **state)
{
    (void)setenv("XDG_RUNTIME_DIR", "/dev/null", 1);
    (void)unsetenv("RUNTIME_DIRECTORY");
    if (mkdtemp(folder) == NULL || chdir(folder) != 0 || mkdir("folder", 0700) != 0) {
        return -1;
    }
    for (size_t i = 0; i < DG_COUNT(files); i++) {
        write_file(files[i].name, files[i].text, files[i].mode);
    }
    return descriptors_note(state);
}

static int remove_folder(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(files); i++) {
        (void)unlink(files[i].name);
    }
    (void)unlink("rig.ini");
    return rmdir("folder") != 0 || chdir("/") != 0 || rmdir(folder) != 0 ? -1 : 0;
}

/* Nothing is new, and nothing has another content. */
static bool is_as_before(void)
{
    size_t count = 0;
    char text[64];
    DIR *all = opendir(".");
    assert_non_null(all);
    for (const struct dirent *entry = readdir(all); entry != NULL; entry = readdir(all)) {
        count += entry->d_name[0] != '.' ? 1u : 0u;
    }
    (void)closedir(all);
    bool same = count == DG_COUNT(files) + 2u; /* the folder, the rig file */
    for (size_t i = 0; i < DG_COUNT(files); i++) {
        FILE *file = fopen(files[i].name, "r");
        assert_non_null(file);
        const size_t n = fread(text, 1, sizeof text, file);
        same = same && n == strlen(files[i].text) && memcmp(text, files[i].text, n) == 0;
        (void)fclose(file);
    }
    return same;
}

static void each_says_why_and_leaves_all_as_it_was(void **state)
{
    static const struct lx_say quiet = {.quiet = true};
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct lx_error error = {.right = ""};
        struct dg_plan plan = {.file = NULL};
        struct lx_rig *rig = NULL;
        sd_event *event = NULL;
        write_file("rig.ini", rows[i].rig, 0600);
        assert_true(sd_event_new(&event) >= 0);
        if (lx_plan_read(&plan, "rig.ini", &error) != 0) {
            fail_msg("%s: %s", rows[i].rig, lx_error_line(&error).text);
        }
        const struct lx_rig_setup setup = {.event = event, .say = &quiet, .plan = &plan};
        const int result = lx_rig_open(&rig, &setup, lx_now(), &error);
        assert_null(rig);
        assert_string_equal(lx_error_line(&error).text, rows[i].line);
        assert_int_equal(result, rows[i].result);
        lx_plan_free(&plan);
        (void)sd_event_unref(event);
        if (!is_as_before()) {
            fail_msg("%s: something is left", rows[i].rig);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_says_why_and_leaves_all_as_it_was),
        cmocka_unit_test(no_descriptor_is_left),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
