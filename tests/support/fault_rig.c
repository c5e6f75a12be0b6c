/* SPDX-License-Identifier: MIT */
#include "fault_rig.h"

#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/biss.h"
#include "drehgeber/bits.h"
#include "drehgeber/cia406.h"
#include "drehgeber/devices.h"
#include "drehgeber/hiperface.h"
#include "drehgeber/instruments.h"
#include "drehgeber/interbus.h"

#define EMCY 0x0BFu

struct fault_rig fault_rig;
const struct dg_fault_limits fault_rig_forever = {.probability_ppm = 1000000, .duration = DG_NEVER};

static void aim(const struct dg_stack *stack, struct dg_world *world,
                const struct dg_store_layout *layout, struct dg_nvm nvm)
{
    memset(&fault_rig.faults, 0, sizeof fault_rig.faults);
    fault_rig.target = (struct dg_fault_target){
        .instrument = dg_instrument_of(stack), .world = world, .layout = layout, .nvm = nvm};
}

void fault_rig_start_hf(void)
{
    assert_int_equal(hf_rig_init(&fault_rig.hf, dg_hf_model_of(dg_device_find("s3684-rs485"))),
                     DG_OK);
    assert_int_equal(hf_rig_power_on(&fault_rig.hf), DG_OK);
    aim(&dg_hf_stack, &fault_rig.hf.world, &dg_hf_layout, ram_nvm_port(&fault_rig.hf.nvm));
}

void fault_rig_start_biss(void)
{
    assert_int_equal(
        biss_rig_init(&fault_rig.biss, dg_biss_model_of(dg_device_find("s3684-biss")), 1), DG_OK);
    assert_int_equal(biss_rig_power_on(&fault_rig.biss), DG_OK);
    aim(&dg_biss_stack, &fault_rig.biss.world, &dg_biss_layout,
        ram_nvm_port(&fault_rig.biss.nvm[0]));
}

void fault_rig_start_co(void)
{
    co_rig_start(&fault_rig.co);
    co_rig_run(&fault_rig.co, FAULT_RIG_LOOK);
    co_rig_forget(&fault_rig.co);
    aim(&dg_cia406_stack, &fault_rig.co.world, dg_cia406_multiturn.layout,
        ram_nvm_port(&fault_rig.co.nvm));
}

static void start_ib_model(const char *model)
{
    assert_int_equal(ib_rig_init(&fault_rig.ib, dg_ib_model_of(dg_device_find(model))), DG_OK);
    assert_int_equal(ib_rig_power_on(&fault_rig.ib), DG_OK);
    (void)ib_rig_cycle(&fault_rig.ib, 0);
    aim(&dg_ib_stack, &fault_rig.ib.world, &dg_ib_layout, ram_nvm_port(&fault_rig.ib.nvm));
}

void fault_rig_start_k3(void)
{
    start_ib_model("ocd-ib-k3");
}

void fault_rig_start_k2(void)
{
    start_ib_model("ocd-ib-k2");
}

uint32_t fault_rig_oldest(void)
{
    assert_int_equal(hf_rig_ask(&fault_rig.hf, "50"),
                     0); /* a reply, and so a look of the monitors */
    const uint8_t first = fault_rig.hf.reply[2];

    for (unsigned i = 0; i < DG_HF_STACK_DEPTH; i++) {
        assert_int_equal(hf_rig_ask(&fault_rig.hf, "50"), 0);
    }
    return first;
}

uint32_t fault_rig_errors(void)
{
    return (uint32_t)biss_rig_get(&fault_rig.biss, 0x69);
}

uint32_t fault_rig_states(void)
{
    (void)biss_rig_frame(&fault_rig.biss, false);
    return (uint32_t)(fault_rig.biss.bits >> 12) & 3u;
}

uint32_t fault_rig_emcy(void)
{
    uint32_t codes = 0;

    co_rig_run(&fault_rig.co, FAULT_RIG_LOOK);
    for (uint32_t i = 0; i < fault_rig.co.count; i++) {
        if (fault_rig.co.frame[i].id == EMCY) {
            codes = codes << 16 | dg_load_le16(fault_rig.co.frame[i].data);
        }
    }
    co_rig_forget(&fault_rig.co);
    return codes;
}

static size_t find(const char *name)
{
    const int index = dg_fault_find(&fault_rig.target, name);

    if (index < 0) {
        fail_msg("%s is not in the catalogue", name);
    }
    return (size_t)index;
}

void fault_rig_set(const char *name)
{
    assert_int_equal(
        dg_fault_set(&fault_rig.faults, &fault_rig.target, find(name), 0, &fault_rig_forever),
        DG_OK);
}

void fault_rig_clear(const char *name)
{
    assert_int_equal(dg_fault_clear(&fault_rig.faults, &fault_rig.target, find(name)), DG_OK);
}
