/* SPDX-License-Identifier: MIT */
/*
 * Encoders on a simulated clocked wire that nobody listens to, in virtual time: the frames that the
 * wire's own master reads are counted all the same, each at its moment, and so is what goes wrong
 * with them. It reads every 100 ms, from the end of the initialisation on (page of the port).
 */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "descriptors.h"
#include "memory_file.h"
#include "timer.h"
#include "virtual_rig.h"

#define READ_EVERY DG_MS(100)

static const struct {
    const char *text;
    dg_ns init;
    bool judges; /* a flipped bit is noticed */
} wires[] = {
    {"[bus chain]\nwire = sim\n"
     "[encoder a]\nmodel = s3684-biss\nbus = chain\n"
     "[encoder b]\nmodel = s3674-biss\nbus = chain\n",
     DG_MS(100), true},
    {"[encoder a]\nmodel = ssi-28\nwire = sim\ninit_ms = 50\nparity = even\n", DG_MS(50), true},
    {"[encoder a]\nmodel = ssi-25\nwire = sim\ninit_ms = 250\nparity = none\n", DG_MS(250), false},
};

struct bench {
    struct virtual_rig rig;
    dg_ns begin;
    dg_ns init;
};

static void open_wire(struct bench *self, size_t index)
{
    const char *text = wires[index].text;
    *self = (struct bench){.init = wires[index].init};
    virtual_rig_open(&self->rig, memory_file_write((const uint8_t *)text, strlen(text)), NULL);
    self->begin = lx_now();
}

static void pass_to(struct bench *self, dg_ns since_begin)
{
    virtual_rig_pass_to(&self->rig, self->begin + since_begin);
}

static void expect_counters(struct bench *self, uint64_t frames, uint64_t silent, uint64_t wrong)
{
    char text[128];
    virtual_rig_ask(&self->rig, "STAT?");
    (void)snprintf(text, sizeof text,
                   "wire_up=1,wire_late=0,wire_frames=%llu,wire_silent=%llu,wire_wrong=%llu,",
                   (unsigned long long)frames, (unsigned long long)silent,
                   (unsigned long long)wrong);
    if (strstr(self->rig.answer, text) == NULL) {
        fail_msg("%s: no %s", self->rig.answer, text);
    }
}

/* --- */

static void frames_are_counted_at_their_moments(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(wires); i++) {
        struct bench bench;
        open_wire(&bench, i);
        expect_counters(&bench, 0, 0, 0);
        pass_to(&bench, bench.init - 1);
        expect_counters(&bench, 0, 0, 0);
        pass_to(&bench, bench.init);
        expect_counters(&bench, 1, 0, 0);
        pass_to(&bench, bench.init + READ_EVERY - 1);
        expect_counters(&bench, 1, 0, 0);
        pass_to(&bench, bench.init + READ_EVERY);
        expect_counters(&bench, 2, 0, 0);
        pass_to(&bench, bench.init + DG_S(3600) - 1); /* nobody has looked since */
        expect_counters(&bench, 36000, 0, 0);
        pass_to(&bench, bench.init + DG_S(3600));
        expect_counters(&bench, 36001, 0, 0);
        virtual_rig_close(&bench.rig);
    }
}

/* So many frames have the fault, whenever it is looked at; then they are good again. */
static void faults_are_counted_by_frames(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(wires); i++) {
        struct bench bench;
        open_wire(&bench, i);
        pass_to(&bench, DG_S(10));
        const uint64_t before = (DG_S(10) - bench.init) / READ_EVERY + 1u;
        expect_counters(&bench, before, 0, 0);
        virtual_rig_order(&bench.rig, "FAUL:SET wire_drop,COUN,3");
        pass_to(&bench, DG_S(20));
        expect_counters(&bench, before + 100, 3, 0);
        virtual_rig_order(&bench.rig, "FAUL:SET wire_damage,COUN,5");
        pass_to(&bench, DG_S(30));
        expect_counters(&bench, before + 200, 3, wires[i].judges ? 5 : 0);
        virtual_rig_order(&bench.rig, "FAUL:SET wire_drop");
        pass_to(&bench, DG_S(40));
        expect_counters(&bench, before + 300, 103, wires[i].judges ? 5 : 0);
        virtual_rig_order(&bench.rig, "FAUL:CLE wire_drop");
        pass_to(&bench, DG_S(50));
        expect_counters(&bench, before + 400, 103, wires[i].judges ? 5 : 0);
        virtual_rig_close(&bench.rig);
    }
}

/* Without power there is no answer: to a frame that is read as to one that is only counted. */
static void without_power_each_frame_is_silent(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(wires); i++) {
        struct bench bench;
        open_wire(&bench, i);
        pass_to(&bench, DG_S(10));
        const uint64_t before = (DG_S(10) - bench.init) / READ_EVERY + 1u;
        virtual_rig_order(&bench.rig, "INST:SEL a");
        virtual_rig_order(&bench.rig, "POW OFF");
        pass_to(&bench, DG_S(1000));
        expect_counters(&bench, before + 9900, 9900, 0);
        virtual_rig_order(&bench.rig, "POW ON");
        pass_to(&bench, DG_S(1001) + bench.init);
        virtual_rig_close(&bench.rig);
    }
}

/* --- */

/* The file in memory that rigs are read from stays. */
static int note(void **state)
{
    (void)memory_file_write((const uint8_t *)"", 0);
    return descriptors_note(state);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_are_counted_at_their_moments),
        cmocka_unit_test(faults_are_counted_by_frames),
        cmocka_unit_test(without_power_each_frame_is_silent),
        cmocka_unit_test(no_descriptor_is_left),
    };
    return cmocka_run_group_tests_name("frames of a simulated wire", tests, note, NULL);
}
