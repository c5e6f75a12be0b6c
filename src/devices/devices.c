/* SPDX-License-Identifier: MIT */
/*
 * The models and their figures. Identities are examples; the command line changes them.
 */
#include "drehgeber/devices.h"

/* What both S36 share: manual 3.1, 5.1.1.2.2, 5.1.4; channels 49h and 4Ah and limits are chosen. */
#define S36_RS485                                                                                  \
    .periods_per_turn = 2048, .steps_per_period = 32, .option_code = 0x00, .memory_blocks = 0x70,  \
    .serial = "123456789", .version = "v1.0.8", .date = "12072019", .temperature_channel = 0x48,   \
    .led_channel = 0x49, .vector_channel = 0x4A, .temperature_min_degc = -40,                      \
    .temperature_max_degc = 120, .led_min_ma = 1, .led_max_ma = 30, .vector_min = 600,             \
    .vector_max = 1400, .speed_max_rpm = 12000, .acceleration_max_krad_s2 = 500,                   \
    .reaction = DG_MS(1), .init = DG_MS(100)

static const struct dg_hf_model s3674_rs485 = {
    S36_RS485,
    .turns = 1,
    .type_code = 0x22,
    .designation = "S3674 RS485+SinCos",
};

static const struct dg_hf_model s3684_rs485 = {
    S36_RS485,
    .turns = 4096,
    .type_code = 0x27,
    .designation = "S3684 RS485+SinCos",
};

/* What both S36 share: manual 5.2.1.3, EDS; times of a serial EEPROM and busy are chosen. */
#define S36_BISS                                                                                   \
    .singleturn_bits = 21, .life_counter = true, .sl_low_at_start = true, .serial = 123456789,     \
    .device_id = {0x04, 0x00, 0xC0, 0x00, 0x00, 0x00}, .busy = DG_US(3),                           \
    .eeprom_read = DG_US(100), .eeprom_write = DG_MS(5), .init = DG_MS(100)

static const struct dg_biss_model s3674_biss = {S36_BISS, .multiturn_bits = 0};
static const struct dg_biss_model s3684_biss = {S36_BISS, .multiturn_bits = 12};

#define F36X8_PASSWORD 0x004B7562u
static const struct dg_cia406_model f3658 = {
    .turns = 1,
    .device = &dg_cia406_singleturn,
    .password = F36X8_PASSWORD,
};
static const struct dg_cia406_model f3668 = {
    .turns = 4096,
    .device = &dg_cia406_multiturn,
    .password = F36X8_PASSWORD,
};

/* What the OCD share: manual 2.1, 5.4; serial number and version are chosen. */
#define OCD_IB                                                                                     \
    .steps = 4096, .temperature_sensor = true, .param_cycles = 3, .serial = 1234567,               \
    .version = 0x0110, .self_test = DG_MS(100)

static const struct dg_ib_model ocd_ib_k1 = {OCD_IB, .profile = DG_IB_K1, .turns = 1};
static const struct dg_ib_model ocd_ib_k2 = {OCD_IB, .profile = DG_IB_K2, .turns = 4096};
static const struct dg_ib_model ocd_ib_k3 = {OCD_IB, .profile = DG_IB_K3, .turns = 4096};

/* clang-format off */
const struct dg_device dg_devices[] = {
    {"s3674-rs485", "RS485 + SinCos (HIPERFACE-compatible)", "2048 periods x 32 steps, singleturn", DG_STACK_HIPERFACE, &s3674_rs485, NULL, NULL, NULL},
    {"s3684-rs485", "RS485 + SinCos (HIPERFACE-compatible)", "2048 periods x 32 steps, 4096 turns", DG_STACK_HIPERFACE, &s3684_rs485, NULL, NULL, NULL},
    {"s3674-biss", "BiSS-C", "21 bit, singleturn", DG_STACK_BISS, NULL, &s3674_biss, NULL, NULL},
    {"s3684-biss", "BiSS-C", "21 bit, 4096 turns", DG_STACK_BISS, NULL, &s3684_biss, NULL, NULL},
    {"f3658", "CANopen (CiA 406)", "65536 steps, singleturn", DG_STACK_CANOPEN, NULL, NULL, &f3658, NULL},
    {"f3668", "CANopen (CiA 406)", "65536 steps, 4096 turns", DG_STACK_CANOPEN, NULL, NULL, &f3668, NULL},
    {"ocd-ib-k1", "INTERBUS, ENCOM profile K1", "4096 steps, singleturn", DG_STACK_INTERBUS, NULL, NULL, NULL, &ocd_ib_k1},
    {"ocd-ib-k2", "INTERBUS, ENCOM profile K2", "4096 steps, 4096 turns", DG_STACK_INTERBUS, NULL, NULL, NULL, &ocd_ib_k2},
    {"ocd-ib-k3", "INTERBUS, ENCOM profile K3", "4096 steps, 4096 turns, parameters", DG_STACK_INTERBUS, NULL, NULL, NULL, &ocd_ib_k3},
};
/* clang-format on */

const size_t dg_device_count = sizeof dg_devices / sizeof dg_devices[0];

/* The library has no strcmp to rely on. */
static bool same(const char *a, const char *b)
{
    while (*a != '\0' && *a == *b) {
        a++;
        b++;
    }
    return *a == *b;
}

const struct dg_device *dg_device_find(const char *name)
{
    for (size_t i = 0; i < dg_device_count; i++) {
        if (same(dg_devices[i].name, name)) {
            return &dg_devices[i];
        }
    }
    return NULL;
}
