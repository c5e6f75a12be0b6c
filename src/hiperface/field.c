/* SPDX-License-Identifier: MIT */
/*
 * Data fields: 4Ah 4Bh 4Ch 4Dh 4Eh (5.1.1.2.1, 5.1.1.2.3, 5.1.2.7 - 5.1.2.11).
 *
 * Region 'fields' has their number and a status byte each, region 'user' their content back to
 * back, region 'field-sums' a CRC-16 over each one's content.
 */
#include <string.h>

#include "drehgeber/crc.h"
#include "hiperface_private.h"

#define STATUS_EXISTS 0x80u
#define STATUS_WRITE_ENABLED 0x40u
#define STATUS_CODE_ENABLED 0x08u
#define STATUS_BLOCKS 0x07u
#define FIELD_MAX 128u
#define SUM_SEED 0xFFFFu

/* Region 'fields', as it is stored. */
struct fields {
    uint8_t count;
    uint8_t status[HF_FIELDS_MAX];
};

/* One field, or the label. */
struct field {
    uint8_t number;
    uint8_t status;
    uint16_t start; /* in region 'user' */
    uint16_t size;
};

static uint8_t blocks_of(uint8_t status)
{
    return (uint8_t)((status & STATUS_BLOCKS) + 1u);
}

static uint8_t access_code_of(const struct dg_hf *self, uint8_t status)
{
    return self->codes[(status >> 4) & 3u];
}

/* Blocks in use by the first `n` fields. */
static uint16_t blocks_used(const struct fields *fields, uint8_t n)
{
    uint16_t used = 0;

    for (uint8_t i = 0; i < n; i++) {
        used = (uint16_t)(used + blocks_of(fields->status[i]));
    }
    return used;
}

/* A table that passes its sum but cannot be true was not written by this device. */
static enum dg_hf_status load_fields(struct dg_hf *self, struct fields *fields)
{
    if (dg_hf_get(self, DG_HF_REGION_FIELDS, fields) != DG_HF_NO_ERROR) {
        return DG_HF_I2C;
    }
    if (fields->count > HF_FIELDS_MAX || blocks_used(fields, fields->count) > self->blocks) {
        return dg_hf_corrupt(self);
    }
    return DG_HF_NO_ERROR;
}

static struct field field_at(const struct fields *fields, uint8_t number)
{
    uint8_t status = fields->status[number];

    return (struct field){.number = number,
                          .status = status,
                          .start = (uint16_t)(blocks_used(fields, number) * HF_BLOCK),
                          .size = (uint16_t)(blocks_of(status) * HF_BLOCK)};
}

/* Find data field `number`, or the label. */
static enum dg_hf_status find_field(struct dg_hf *self, uint8_t number, struct field *out)
{
    struct fields fields;

    if (number == HF_LABEL) {
        *out = (struct field){.number = HF_LABEL, .status = HF_LABEL_STATUS, .size = HF_LABEL_SIZE};
        /* A label that failed its start-up check is not there (5.1.3.14). */
        return dg_store_damaged(&self->store, DG_HF_REGION_LABEL) ? DG_HF_FIELD_NUMBER
                                                                  : DG_HF_NO_ERROR;
    }
    enum dg_hf_status status = load_fields(self, &fields);
    if (status != DG_HF_NO_ERROR) {
        return status;
    }
    if (number >= fields.count) {
        return DG_HF_FIELD_NUMBER;
    }
    *out = field_at(&fields, number);
    return DG_HF_NO_ERROR;
}

/* The content of a data field, if its sum is right. */
static enum dg_hf_status load_content(struct dg_hf *self, const struct field *field, uint8_t *to)
{
    uint8_t sum[2];

    if (dg_store_read(&self->store, DG_HF_REGION_USER, field->start, to, field->size) != DG_OK ||
        dg_store_read(&self->store, DG_HF_REGION_FIELD_SUMS, (uint16_t)(2u * field->number), sum,
                      sizeof sum) != DG_OK) {
        return DG_HF_I2C;
    }
    return dg_crc16(SUM_SEED, to, field->size) == dg_load_be16(sum) ? DG_HF_NO_ERROR
                                                                    : dg_hf_corrupt(self);
}

/* Add the sum of `content` to the open commit. */
static int stage_sum(struct dg_hf *self, const struct field *field, const uint8_t *content)
{
    uint8_t sum[2];

    dg_store_be16(sum, dg_crc16(SUM_SEED, content, field->size));
    return dg_store_stage(&self->store, DG_HF_REGION_FIELD_SUMS, (uint16_t)(2u * field->number),
                          sum, sizeof sum);
}

/* Field, code and bounds of 4Ah and 4Bh: {number, offset, count, code, ...}. */
static enum dg_hf_status open_field(struct dg_hf *self, const uint8_t *data, struct field *field)
{
    enum dg_hf_status status = find_field(self, data[0], field);

    if (status != DG_HF_NO_ERROR) {
        return status;
    }
    if ((field->status & STATUS_CODE_ENABLED) != 0 &&
        data[3] != access_code_of(self, field->status)) {
        return DG_HF_ACCESS_CODE;
    }
    if (data[2] == 0 || data[1] + data[2] > field->size) {
        return DG_HF_FIELD_OFFSET;
    }
    return DG_HF_NO_ERROR;
}

enum dg_hf_status dg_hf_read_data(struct dg_hf *self, struct hf_request *rq)
{
    uint8_t content[FIELD_MAX];
    struct field field;
    enum dg_hf_status status = open_field(self, rq->data, &field);

    if (status != DG_HF_NO_ERROR) {
        return status;
    }
    if (field.number == HF_LABEL) {
        status = dg_hf_get(self, DG_HF_REGION_LABEL, content);
    } else {
        status = load_content(self, &field, content);
    }
    dg_write_bytes(&rq->reply, rq->data, 3);
    dg_write_bytes(&rq->reply, &content[rq->data[1]], rq->data[2]);
    return status;
}

enum dg_hf_status dg_hf_save_data(struct dg_hf *self, struct hf_request *rq)
{
    uint8_t content[FIELD_MAX];
    struct field field;
    enum dg_hf_status status = open_field(self, rq->data, &field);

    if (status == DG_HF_NO_ERROR && (field.status & STATUS_WRITE_ENABLED) == 0) {
        status = DG_HF_WRITE_PROTECTED;
    }
    if (status == DG_HF_NO_ERROR) {
        status = load_content(self, &field, content);
    }
    if (status != DG_HF_NO_ERROR) {
        return status;
    }
    memcpy(&content[rq->data[1]], &rq->data[4], rq->data[2]);
    dg_store_begin(&self->store);
    (void)stage_sum(self, &field, content);
    (void)dg_store_stage(&self->store, DG_HF_REGION_USER, (uint16_t)(field.start + rq->data[1]),
                         &rq->data[4], rq->data[2]);
    dg_write_bytes(&rq->reply, rq->data, 3);
    return dg_hf_io(dg_store_commit(&self->store));
}

enum dg_hf_status dg_hf_field_status(struct dg_hf *self, struct hf_request *rq)
{
    struct field field = {0};
    enum dg_hf_status status = find_field(self, rq->data[0], &field);

    dg_write_u8(&rq->reply, rq->data[0]);
    dg_write_u8(&rq->reply, field.status);
    return status;
}

/* Put `fields` in force; with `field`, together with the sum of its `content`. */
static enum dg_hf_status commit_fields(struct dg_hf *self, const struct fields *fields,
                                       const struct field *field, const uint8_t *content)
{
    dg_store_begin(&self->store);
    (void)dg_store_stage(&self->store, DG_HF_REGION_FIELDS, 0, fields, sizeof *fields);
    if (field != NULL) {
        (void)stage_sum(self, field, content);
    }
    return dg_hf_io(dg_store_commit(&self->store));
}

/* Give the last field (new, or so far `kept` bytes long) its status; added bytes read FFh. The
 * bytes are cleared first: nobody owns them until the table says so, so a power cut in between
 * changes nothing. */
static enum dg_hf_status resize_field(struct dg_hf *self, struct fields *fields, uint8_t status,
                                      uint16_t kept)
{
    uint8_t content[FIELD_MAX];
    uint8_t number = (uint8_t)(fields->count - 1u);
    enum dg_hf_status result = DG_HF_NO_ERROR;

    memset(content, 0xFF, sizeof content);
    if (kept > 0) {
        struct field old = field_at(fields, number);
        result = load_content(self, &old, content);
    }
    if (result != DG_HF_NO_ERROR) {
        return result;
    }
    fields->status[number] = status;
    struct field field = field_at(fields, number);
    if (field.start + field.size > self->blocks * HF_BLOCK) {
        return DG_HF_FIELD_SIZE;
    }
    result = dg_hf_io(dg_store_put(&self->store, DG_HF_REGION_USER, (uint16_t)(field.start + kept),
                                   &content[kept], (uint16_t)(field.size - kept)));
    if (result != DG_HF_NO_ERROR) {
        return result;
    }
    return commit_fields(self, fields, &field, content);
}

/* 4Dh on a field that exists: erase it, change its status, enlarge it. */
static enum dg_hf_status modify_field(struct dg_hf *self, struct fields *fields,
                                      const uint8_t *data)
{
    uint8_t number = data[0];
    uint8_t wanted = data[1];
    uint8_t old = fields->status[number];
    bool erase = (wanted & STATUS_EXISTS) == 0;
    bool last = number + 1u == fields->count;

    if (data[2] != access_code_of(self, old)) {
        return DG_HF_ACCESS_CODE;
    }
    if (erase) {
        if (!last || (wanted | STATUS_EXISTS) != old) {
            return DG_HF_FIELD_NUMBER;
        }
        fields->count--;
        fields->status[number] = 0;
        return commit_fields(self, fields, NULL, NULL);
    }
    if (blocks_of(wanted) == blocks_of(old)) {
        fields->status[number] = wanted;
        return commit_fields(self, fields, NULL, NULL);
    }
    if (!last) {
        return DG_HF_FIELD_NUMBER;
    }
    if (blocks_of(wanted) < blocks_of(old)) {
        return DG_HF_FIELD_SIZE; /* a field can only grow */
    }
    return resize_field(self, fields, wanted, (uint16_t)(blocks_of(old) * HF_BLOCK));
}

static enum dg_hf_status create_data_field(struct dg_hf *self, struct fields *fields,
                                           const uint8_t *data)
{
    bool label = data[0] == HF_LABEL;

    if (!label && (data[0] != fields->count || (data[1] & STATUS_EXISTS) == 0)) {
        return DG_HF_FIELD_NUMBER;
    }
    if (data[2] != access_code_of(self, data[1])) {
        return DG_HF_ACCESS_CODE;
    }
    if (label || blocks_used(fields, fields->count) + blocks_of(data[1]) > self->blocks) {
        return DG_HF_FIELD_SIZE;
    }
    fields->count++;
    return resize_field(self, fields, data[1], 0);
}

enum dg_hf_status dg_hf_create_field(struct dg_hf *self, struct hf_request *rq)
{
    struct fields fields;
    enum dg_hf_status status = load_fields(self, &fields);

    if (status != DG_HF_NO_ERROR) {
        return status;
    }
    dg_write_bytes(&rq->reply, rq->data, 2);
    return rq->data[0] < fields.count ? modify_field(self, &fields, rq->data)
                                      : create_data_field(self, &fields, rq->data);
}

enum dg_hf_status dg_hf_available_memory(struct dg_hf *self, struct hf_request *rq)
{
    struct fields fields;
    enum dg_hf_status status = load_fields(self, &fields);

    if (status == DG_HF_NO_ERROR) {
        dg_write_u8(&rq->reply, (uint8_t)(self->blocks - blocks_used(&fields, fields.count)));
        dg_write_u8(&rq->reply, fields.count);
    }
    return status;
}
