/* SPDX-License-Identifier: MIT */
/*
 * The commands around the device itself: analog values, counter, access codes, type label, address,
 * serial number, UART setting.
 */
#include "hiperface_private.h"

#define COUNTER_MAX 0xFFFFFFu
#define TYPE_CODE 0u
#define OPTION_CODE 1u
#define SERIAL_TEXT 2u
#define SERIAL_TEXT_SIZE 37u
#define TYPE_SIZE (SERIAL_TEXT + SERIAL_TEXT_SIZE)
#define VERSION_LAST 28u /* the version is followed by 00h (5.1.2.17) */

static uint16_t temperature_degc(const struct dg_hf *self, dg_ns now)
{
    int32_t mdegc = self->setup.world->temperature_mdegc;
    /* To the nearest degree; away from zero in the middle. */
    int32_t degc = mdegc / 1000 + mdegc % 1000 / 500;

    (void)now;
    degc = degc < INT16_MIN ? INT16_MIN : degc;
    return (uint16_t)(degc > INT16_MAX ? INT16_MAX : degc);
}

static uint16_t led_current_ma(const struct dg_hf *self, dg_ns now)
{
    uint32_t ma = self->setup.world->led_current_ua / 1000u;

    (void)now;
    return (uint16_t)(ma > 0xFFFFu ? 0xFFFFu : ma);
}

/* Length of the vector (sin, cos) in permille of its nominal length. */
static uint16_t vector_length(const struct dg_hf *self, dg_ns now)
{
    struct dg_hf_sincos s;

    dg_hf_sincos(self, now, &s);
    int64_t sin_uv = s.sin_plus_uv - s.sin_minus_uv;
    int64_t cos_uv = s.cos_plus_uv - s.cos_minus_uv;
    return (uint16_t)((dg_isqrt((uint64_t)(sin_uv * sin_uv + cos_uv * cos_uv)) + 250u) / 500u);
}

enum dg_hf_status dg_hf_read_analog(struct dg_hf *self, struct hf_request *rq)
{
    static uint16_t (*const sources[])(const struct dg_hf *, dg_ns) = {
        temperature_degc,
        led_current_ma,
        vector_length,
    };

    for (uint8_t i = 0; i < DG_COUNT(sources); i++) {
        if (self->channels[i] == rq->data[0]) {
            dg_write_u8(&rq->reply, rq->data[0]);
            dg_write_be16(&rq->reply, sources[i](self, rq->now));
            return DG_HF_NO_ERROR;
        }
    }
    return DG_HF_ARGUMENT;
}

static enum dg_hf_status load_counter(struct dg_hf *self, uint32_t *out)
{
    uint8_t bytes[3] = {0};
    enum dg_hf_status status = dg_hf_get(self, DG_HF_REGION_COUNTER, bytes);

    *out = dg_load_be24(bytes);
    return status;
}

static enum dg_hf_status store_counter(struct dg_hf *self, uint32_t value)
{
    uint8_t bytes[3];

    dg_store_be24(bytes, value);
    return dg_hf_put(self, DG_HF_REGION_COUNTER, bytes);
}

enum dg_hf_status dg_hf_read_counter(struct dg_hf *self, struct hf_request *rq)
{
    uint32_t counter;
    enum dg_hf_status status = load_counter(self, &counter);

    dg_write_be24(&rq->reply, counter);
    return status;
}

enum dg_hf_status dg_hf_count_up(struct dg_hf *self, struct hf_request *rq)
{
    uint32_t counter;
    enum dg_hf_status status = load_counter(self, &counter);

    (void)rq;
    if (status != DG_HF_NO_ERROR) {
        return status;
    }
    if (counter == COUNTER_MAX) {
        dg_hf_push(self, DG_HF_COUNTER); /* R17 */
        return DG_HF_COUNTER;
    }
    return store_counter(self, counter + 1u);
}

enum dg_hf_status dg_hf_erase_counter(struct dg_hf *self, struct hf_request *rq)
{
    (void)rq;
    return store_counter(self, 0);
}

enum dg_hf_status dg_hf_modify_key(struct dg_hf *self, struct hf_request *rq)
{
    uint8_t number = rq->data[0];
    uint8_t codes[sizeof self->codes];

    if (number >= sizeof codes) {
        return DG_HF_ARGUMENT;
    }
    if (rq->data[1] != self->codes[number]) {
        return DG_HF_ACCESS_CODE;
    }
    for (uint8_t i = 0; i < sizeof codes; i++) {
        codes[i] = i == number ? rq->data[2] : self->codes[i];
    }
    enum dg_hf_status status = dg_hf_put(self, DG_HF_REGION_CODES, codes);
    if (status == DG_HF_NO_ERROR) {
        self->codes[number] = rq->data[2];
    }
    dg_write_u8(&rq->reply, number);
    return status;
}

enum dg_hf_status dg_hf_read_type_label(struct dg_hf *self, struct hf_request *rq)
{
    uint8_t type[TYPE_SIZE] = {0};
    enum dg_hf_status status = dg_hf_get(self, DG_HF_REGION_TYPE, type);

    dg_write_u8(&rq->reply, self->uart_stored);
    dg_write_u8(&rq->reply, type[TYPE_CODE]);
    dg_write_u8(&rq->reply, self->implemented);
    dg_write_u8(&rq->reply, type[OPTION_CODE]);
    return status;
}

enum dg_hf_status dg_hf_read_serial(struct dg_hf *self, struct hf_request *rq)
{
    uint8_t type[TYPE_SIZE] = {0};
    enum dg_hf_status status = dg_hf_get(self, DG_HF_REGION_TYPE, type);

    type[SERIAL_TEXT + VERSION_LAST] = 0;
    dg_write_bytes(&rq->reply, &type[SERIAL_TEXT], SERIAL_TEXT_SIZE);
    return status;
}

/* UART setting and address share a region. */
static enum dg_hf_status store_line(struct dg_hf *self, uint8_t uart, uint8_t address)
{
    const uint8_t bytes[] = {uart, address};
    enum dg_hf_status status = dg_hf_put(self, DG_HF_REGION_UART, bytes);

    if (status == DG_HF_NO_ERROR) {
        self->uart_stored = uart;
        self->address = address;
    }
    return status;
}

enum dg_hf_status dg_hf_assign_address(struct dg_hf *self, struct hf_request *rq)
{
    uint8_t address = rq->data[0];

    if (address < DG_HF_ADDRESS_DEFAULT || address > DG_HF_ADDRESS_LAST) {
        return DG_HF_ARGUMENT;
    }
    return store_line(self, self->uart_stored, address);
}

enum dg_hf_status dg_hf_configure_uart(struct dg_hf *self, struct hf_request *rq)
{
    uint8_t setting = rq->data[0];
    struct dg_hf_uart uart;

    if (dg_hf_uart_decode(setting, &uart) != DG_OK) {
        return DG_HF_ARGUMENT;
    }
    enum dg_hf_status status = store_line(self, setting, self->address);
    if (status == DG_HF_NO_ERROR) {
        self->uart_next = setting; /* in force after 53h or power-on (R15) */
    }
    dg_write_u8(&rq->reply, setting);
    return status;
}
