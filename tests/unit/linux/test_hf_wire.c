/* SPDX-License-Identifier: MIT */
/* What goes wrong on the line of RS485 encoders, and the ports and files it is made of. */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "drehgeber/instruments.h"
#include "hf_rig.h"
#include "line_bus.h"
#include "line_rig.h"

/* --- faults --- */

static void a_dropped_reply_does_not_come(void **state)
{
    struct line_rig rig;
    (void)state;
    line_rig_plan(&rig, 2, NULL);
    line_rig_open_pty(&rig);
    line_rig_bend(&rig, 0, DG_WIRE_DROP, 1);
    line_rig_silent(&rig, 0x40);
    assert_int_equal(line_rig_device(&rig, 0)->counters.replies, 1);
    line_rig_answers(&rig, 0x40);
    line_rig_close(&rig);
}

/* Counted are requests for this encoder, not those for its neighbour. */
static void a_deaf_encoder_hears_no_request(void **state)
{
    struct line_rig rig;
    (void)state;
    line_rig_plan(&rig, 2, NULL);
    line_rig_open_pty(&rig);
    line_rig_bend(&rig, 0, DG_WIRE_DEAF, 2);
    line_rig_answers(&rig, 0x41);
    line_rig_silent(&rig, 0x40);
    line_rig_silent(&rig, 0x40);
    assert_int_equal(line_rig_device(&rig, 0)->counters.frames, 0);
    line_rig_answers(&rig, 0x40);
    line_rig_close(&rig);
}

static void a_damaged_reply_has_one_wrong_bit(void **state)
{
    struct line_rig rig;
    (void)state;
    line_rig_plan(&rig, 2, NULL);
    line_rig_open_pty(&rig);
    line_rig_bend(&rig, 0, DG_WIRE_DAMAGE, 1);
    line_rig_request(&rig, 0x40, LINE_READ_POSITION);
    assert_int_equal(line_rig_receive(&rig, 7, LINE_PATIENCE), 7);
    const uint8_t wanted[] = {0x40, 0x42, 0, 0, 0, 0, 0x02};
    unsigned bits = 0;
    for (size_t i = 0; i < sizeof wanted; i++) {
        bits += (unsigned)__builtin_popcount((unsigned)(rig.reply[i] ^ wanted[i]));
    }
    assert_int_equal(bits, 1);
    assert_int_equal(line_rig_device(&rig, 1)->counters.damaged, 1);
    line_rig_answers(&rig, 0x40);
    line_rig_close(&rig);
}

static void a_duplicated_reply_comes_twice(void **state)
{
    struct line_rig rig;
    (void)state;
    line_rig_plan(&rig, 1, NULL);
    line_rig_open_pty(&rig);
    line_rig_bend(&rig, 0, DG_WIRE_DUPLICATE, 1);
    line_rig_request(&rig, 0x40, LINE_READ_POSITION);
    assert_int_equal(line_rig_receive(&rig, 15, DG_MS(100)), 14);
    assert_memory_equal(rig.reply, rig.reply + 7, 7);
    line_rig_answers(&rig, 0x40);
    line_rig_close(&rig);
}

static void a_delayed_reply_comes_late(void **state)
{
    struct line_rig rig;
    (void)state;
    const dg_ns delay = (dg_ns)dg_fault_wire_value(&dg_hf_instrument, DG_WIRE_DELAY);
    line_rig_plan(&rig, 1, NULL);
    line_rig_open_pty(&rig);
    line_rig_bend(&rig, 0, DG_WIRE_DELAY, 1);
    line_rig_request(&rig, 0x40, LINE_READ_POSITION);
    const dg_ns begin = lx_now();
    assert_int_equal(line_rig_receive(&rig, 7, LINE_PATIENCE), 7);
    const dg_ns took = dg_elapsed(lx_now(), begin);
    assert_true(took >= delay);
    /* Not twice, unless this process stood still, which the bus counts. When exactly is in
     * golden/traces. */
    assert_true(took < 2 * delay || rig.bus->late + rig.bus->stalls > 0);
    line_rig_answers(&rig, 0x40);
    line_rig_close(&rig);
}

/* --- the pty itself --- */

struct place {
    char folder[32];
    char link[64];
};

static void make_place(struct place *self)
{
    (void)snprintf(self->folder, sizeof self->folder, "/tmp/hf_bus.XXXXXX");
    assert_non_null(mkdtemp(self->folder));
    (void)snprintf(self->link, sizeof self->link, "%s/line", self->folder);
}

static void remove_place(const struct place *self)
{
    struct stat info;
    assert_int_equal(lstat(self->link, &info), -1); /* the link goes with its bus */
    assert_int_equal(rmdir(self->folder), 0);
}

/* Take the slave side away from the bus: a hang-up. */
static void break_pty(struct line_rig *self)
{
    char path[LX_BUS_ADDRESS_MAX];
    self->bus->ops->address(self->bus, self->station, path, sizeof path);
    (void)close(self->master);
    self->master = -1;
    const int null = open("/dev/null", O_RDWR | O_CLOEXEC);
    for (int fd = 0; fd < 256; fd++) {
        char name[32];
        char target[64];
        (void)snprintf(name, sizeof name, "/proc/self/fd/%d", fd);
        const ssize_t n = readlink(name, target, sizeof target - 1);
        if (n > 0 && (size_t)n == strlen(path) && memcmp(target, path, (size_t)n) == 0) {
            assert_int_equal(dup2(null, fd), fd);
        }
    }
    (void)close(null);
}

static void a_pty_that_has_gone_is_made_anew(void **state)
{
    struct place place;
    struct line_rig rig;
    struct stat info;
    (void)state;
    make_place(&place);
    line_rig_plan(&rig, 2, place.link);
    line_rig_open_pty(&rig);
    line_rig_answers(&rig, 0x41);
    break_pty(&rig);
    line_rig_run(&rig, DG_MS(100));
    assert_int_equal(lstat(place.link, &info), -1);
    line_rig_run(&rig, DG_MS(1100));
    rig.master = open(place.link, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    assert_true(rig.master >= 0);
    line_rig_answers(&rig, 0x41);
    line_rig_close(&rig);
    remove_place(&place);
}

/* Two buses of one process: the second is refused the link of the first, which keeps its lock. */
static void a_link_in_use_is_refused_in_the_same_process(void **state)
{
    struct place place;
    struct line_rig rigs[3];
    struct lx_error error = {.right = ""};
    char pid[16];
    (void)state;
    make_place(&place);
    line_rig_plan(&rigs[0], 1, place.link);
    line_rig_open_pty(&rigs[0]);
    (void)snprintf(pid, sizeof pid, "%ld", (long)getpid());
    for (size_t i = 1; i < 3; i++) {
        line_rig_plan(&rigs[i], 1, place.link);
        line_rig_prepare(&rigs[i]);
        line_rig_make(&rigs[i], &line_rig_pty);
        assert_int_equal(rigs[i].bus->ops->open(rigs[i].bus, lx_now(), &error), -1);
        assert_non_null(strstr(lx_error_line(&error).text, pid));
        line_rig_close(&rigs[i]);
    }
    line_rig_answers(&rigs[0], 0x40);
    line_rig_close(&rigs[0]);
    remove_place(&place);
}

/* --- a UART --- */

/* The slave side of a pty stands for it; the test has the master side. */
static void several_share_a_tty(void **state)
{
    static const struct lx_wire tty = {.make = lx_line_bus_make, .open_port = lx_tty_open};
    struct line_rig rig;
    (void)state;
    const int far = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    assert_true(far >= 0 && grantpt(far) == 0 && unlockpt(far) == 0);
    line_rig_plan(&rig, 2, ptsname(far));
    line_rig_open(&rig, &tty);
    rig.master = far;
    line_rig_run(&rig, DG_MS(110));
    line_rig_answers(&rig, 0x40);
    line_rig_answers(&rig, 0x41);
    /* The second one goes to 19200 Bd; the UART stays with the first one. */
    (void)line_rig_ask(&rig, 0x41, "57 E5 55", 4);
    line_rig_request(&rig, 0x41, "53");
    line_rig_run(&rig, DG_MS(120));
    line_rig_silent(&rig, 0x41);
    line_rig_answers(&rig, 0x40);
    assert_true(line_rig_device(&rig, 1)->counters.damaged >= 3);
    line_rig_close(&rig);
}

static struct lx_serial *open_timed(const struct lx_serial_setup *setup, struct lx_error *error)
{
    struct lx_serial *port = lx_pty_open(setup, error);
    port->timed = true;
    return port;
}

/* A UART that does the timing gets whole replies at once; the neighbours hear them in their time.
 * Two at once: the later one follows, damaged. */
static void a_uart_gets_whole_replies(void **state)
{
    static const struct lx_wire timed = {.make = lx_line_bus_make, .open_port = open_timed};
    struct line_rig rig;
    (void)state;
    line_rig_plan(&rig, 3, NULL);
    rig.plan.encoders[1].address = 0x40;
    rig.shaft = (dg_angle)0x0F0F << 32;
    line_rig_open_made(&rig, &timed);
    line_rig_request(&rig, 0x42, "56");
    const size_t n = line_rig_receive(&rig, 1, LINE_PATIENCE);
    assert_int_equal(n, 40);
    assert_true(line_rig_device(&rig, 0)->counters.others <=
                1); /* the request, the reply's begin */
    line_rig_run(&rig, DG_MS(50));
    assert_int_equal(line_rig_device(&rig, 0)->counters.others, 2);
    assert_int_equal(line_rig_device(&rig, 0)->last_rx, line_rig_device(&rig, 1)->last_rx);
    line_rig_request(&rig, 0x40, LINE_READ_POSITION);
    assert_int_equal(line_rig_receive(&rig, 14, LINE_PATIENCE), 14);
    assert_int_equal(hf_rig_xor(rig.reply, 7), 0);
    rig.shaft = 0;
    line_rig_close(&rig);
}

/* A new EEPROM gets the plan's address, an old one keeps its own. */
static void a_file_keeps_its_address(void **state)
{
    struct place place;
    char file[96];
    (void)state;
    make_place(&place);
    (void)snprintf(file, sizeof file, "%s/encoder.nvm", place.folder);
    for (int round = 0; round < 2; round++) {
        struct line_rig rig;
        line_rig_plan(&rig, 1, NULL);
        rig.plan.encoders[0].address = round == 0 ? 0x4A : 0x4B;
        rig.plan.encoders[0].nvm = dg_plan_copy(&rig.plan, file);
        line_rig_open_pty(&rig);
        line_rig_answers(&rig, 0x4A);
        line_rig_close(&rig);
    }
    assert_int_equal(unlink(file), 0);
    remove_place(&place);
}

/* Once when its delivery state is made, once by the encoder: whoever opened it knows what is in it.
 */
static unsigned mounted;
int __real_dg_hf_mount(struct dg_store *self, const struct dg_hf_model *model, struct dg_nvm nvm);
int __wrap_dg_hf_mount(struct dg_store *self, const struct dg_hf_model *model, struct dg_nvm nvm);
int __wrap_dg_hf_mount(struct dg_store *self, const struct dg_hf_model *model, struct dg_nvm nvm)
{
    mounted++;
    return __real_dg_hf_mount(self, model, nvm);
}

static void power_mounts_an_eeprom_once(void **state)
{
    struct line_rig rig;
    (void)state;
    mounted = 0;
    line_rig_plan(&rig, 2, NULL);
    line_rig_open_pty(&rig);
    assert_int_equal(mounted, 2 * 2);
    line_rig_answers(&rig, 0x40);
    line_rig_close(&rig);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_dropped_reply_does_not_come),
        cmocka_unit_test(a_deaf_encoder_hears_no_request),
        cmocka_unit_test(a_damaged_reply_has_one_wrong_bit),
        cmocka_unit_test(a_duplicated_reply_comes_twice),
        cmocka_unit_test(a_delayed_reply_comes_late),
        cmocka_unit_test(a_pty_that_has_gone_is_made_anew),
        cmocka_unit_test(a_link_in_use_is_refused_in_the_same_process),
        cmocka_unit_test(several_share_a_tty),
        cmocka_unit_test(a_uart_gets_whole_replies),
        cmocka_unit_test(a_file_keeps_its_address),
        cmocka_unit_test(power_mounts_an_eeprom_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
