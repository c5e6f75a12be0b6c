/* SPDX-License-Identifier: MIT */
/*
 * Parameters of the TPDOs: 1800h and 1A00h (CiA 301).
 */
#include <string.h>

#include "co_od.h"
#include "co_pdo.h"

/* Sub-indices of 1800h. */
enum sub_index {
    SUB_COB_ID = 1,
    SUB_TYPE = 2,
    SUB_INHIBIT = 3,
    SUB_EVENT_TIMER = 5,
};

/* ------------------------------------------------------------ mapping */

/* What an entry `index << 16 | sub << 8 | bits` maps. */
static enum dg_co_abort find_mapped(const struct dg_co_node *self, uint32_t entry,
                                    struct dg_co_object *object)
{
    enum dg_co_abort abort = dg_co_find(self->setup.device, entry & 0xFFFFFF00u, object);

    if (abort != DG_CO_OK) {
        return abort;
    }
    if (!co_is(object, DG_CO_MAP | DG_CO_R)) {
        return DG_CO_NOT_MAPPABLE;
    }
    const uint32_t bits = co_type(object) == DG_CO_WIDE ? 64u : 8u * co_size(object);
    return (entry & 0xFFu) == bits ? DG_CO_OK : DG_CO_INCOMPATIBLE;
}

/* One more object. */
static void append_object(struct dg_co_tpdo *tpdo, const struct dg_co_object *object)
{
    uint8_t size = co_size(object);

    if (co_is(object, DG_CO_EVENT)) {
        tpdo->event_bytes |= (uint8_t)(((1u << size) - 1u) << tpdo->length);
    }
    tpdo->mapped[tpdo->mapped_count++] = dg_co_number(object);
    tpdo->length = (uint8_t)(tpdo->length + size);
}

/* Entries 1..count to rows; an entry of 0 is an unused one. Only while the TPDO is not valid, or
 * with the entries it has. */
static enum dg_co_abort resolve_entries(struct dg_co_node *self, uint8_t n, uint32_t count)
{
    struct dg_co_tpdo *tpdo = &self->tpdo[n];

    tpdo->mapped_count = 0;
    tpdo->length = 0;
    tpdo->event_bytes = 0;
    memset(tpdo->last, 0, sizeof tpdo->last); /* zeros behind the data */
    if (count > DG_CO_MAPPED_MAX) {
        return DG_CO_PDO_LENGTH;
    }
    for (uint8_t i = 0; i < count; i++) {
        uint32_t entry = self->value[CO_TPDO(n, CO_PDO_ENTRIES) + i];
        struct dg_co_object object;
        if (entry == 0) {
            continue;
        }
        const enum dg_co_abort abort = find_mapped(self, entry, &object);
        if (abort != DG_CO_OK) {
            return abort;
        }
        const uint32_t end = tpdo->length + (entry & 0xFFu) / 8u;
        if (end > 8u) {
            return DG_CO_PDO_LENGTH;
        }
        while (tpdo->length < end) {
            append_object(tpdo, &object);
            object.row--; /* the other half of 64 bits */
        }
    }
    return DG_CO_OK;
}

/*
 * The five steps: 1 TPDO not valid (1800h:1 bit 31), 2 sub 0 = 0, 3 entries, 4 sub 0 = n, 5 valid.
 */
static enum dg_co_abort check_mapping(struct dg_co_node *self, uint8_t n, uint8_t sub,
                                      uint32_t wanted)
{
    struct dg_co_object object;

    if (self->tpdo[n].valid) {
        return DG_CO_ACCESS;
    }
    if (sub == 0) {
        return resolve_entries(self, n, wanted);
    }
    if (co_pdo_parameter(self, n, CO_PDO_MAPPED) != 0) {
        return DG_CO_ACCESS;
    }
    return wanted != 0 ? find_mapped(self, wanted, &object) : DG_CO_OK;
}

enum dg_co_abort dg_co_hook_mapping(struct dg_co_node *self, const struct dg_co_object *object,
                                    enum dg_co_op op, uint32_t *value)
{
    uint8_t n = (uint8_t)object->index; /* 1A00h + n */

    return op == DG_CO_WRITE ? check_mapping(self, n, object->sub, *value) : DG_CO_OK;
}

/* ------------------------------------------------------------ communication parameters */

static bool is_reserved(uint32_t type)
{
    return type > CO_PDO_CYCLIC_MAX && type < CO_PDO_REQUEST_SYNC;
}

/* A valid TPDO keeps its CAN-ID; which one it has is the master's business, even if another service
 * has it, too (C43). 80000000h is how masters switch one off: the CAN-ID 0 in it is never used. */
static enum dg_co_abort check_cob_id(struct dg_co_node *self, uint8_t n, uint32_t wanted)
{
    const struct dg_co_tpdo *tpdo = &self->tpdo[n];
    uint32_t id = wanted & CO_COB_CAN_ID;
    bool valid = (wanted & CO_COB_INVALID) == 0;

    if ((wanted & ~(CO_COB_INVALID | CO_COB_BIT30 | CO_COB_CAN_ID)) != 0) {
        return DG_CO_RANGE;
    }
    if ((valid || id != 0) && dg_co_restricted(id)) {
        return DG_CO_RANGE;
    }
    if (!valid) {
        return DG_CO_OK;
    }
    if (tpdo->valid) {
        return id == tpdo->can_id ? DG_CO_OK : DG_CO_RANGE;
    }
    uint32_t count = co_pdo_parameter(self, n, CO_PDO_MAPPED);
    bool complete = resolve_entries(self, n, count) == DG_CO_OK && tpdo->length != 0 &&
                    !is_reserved(co_pdo_parameter(self, n, CO_PDO_TYPE));
    return complete ? DG_CO_OK : DG_CO_RANGE;
}

static enum dg_co_abort check_type(struct dg_co_node *self, uint8_t n, uint32_t wanted)
{
    (void)self;
    (void)n;
    return is_reserved(wanted) ? DG_CO_RANGE : DG_CO_OK;
}

/* Constant while the TPDO is valid; writing what is there changes nothing. */
static enum dg_co_abort check_inhibit(struct dg_co_node *self, uint8_t n, uint32_t wanted)
{
    bool changes = wanted != co_pdo_parameter(self, n, CO_PDO_INHIBIT_100US);

    return self->tpdo[n].valid && changes ? DG_CO_RANGE : DG_CO_OK;
}

/* A COB-ID that has passed check_cob_id() comes into force. */
static void adopt_cob_id(struct dg_co_node *self, uint8_t n)
{
    struct dg_co_tpdo *tpdo = &self->tpdo[n];
    uint32_t cob_id = co_pdo_parameter(self, n, CO_PDO_COB_ID);
    bool was_valid = tpdo->valid;

    tpdo->can_id = (uint16_t)(cob_id & CO_COB_CAN_ID);
    tpdo->valid = (cob_id & CO_COB_INVALID) == 0;
    tpdo->rtr_allowed = (cob_id & CO_COB_BIT30) == 0;
    if (tpdo->valid != was_valid) {
        tpdo->inhibit_until = 0;
        dg_co_pdo_restart(self, n);
    }
}

/* The phase begins anew; an event still waits if the new type has events. */
static void adopt_type(struct dg_co_node *self, uint8_t n)
{
    struct dg_co_tpdo *tpdo = &self->tpdo[n];

    tpdo->type = (uint8_t)co_pdo_parameter(self, n, CO_PDO_TYPE);
    bool waits = tpdo->pending && co_pdo_takes_events(tpdo->type);
    dg_co_pdo_restart(self, n);
    tpdo->pending = waits;
}

/* By sub-index. */
static const struct {
    enum dg_co_abort (*check)(struct dg_co_node *self, uint8_t n, uint32_t wanted); /* or NULL */
    void (*adopt)(struct dg_co_node *self, uint8_t n); /* NULL: read when it is needed */
} parameters[] = {
    [SUB_COB_ID] = {check_cob_id, adopt_cob_id},
    [SUB_TYPE] = {check_type, adopt_type},
    [SUB_INHIBIT] = {check_inhibit, NULL},
    [SUB_EVENT_TIMER] = {NULL, dg_co_pdo_rearm},
};

enum dg_co_abort dg_co_hook_tpdo(struct dg_co_node *self, const struct dg_co_object *object,
                                 enum dg_co_op op, uint32_t *value)
{
    uint8_t n = (uint8_t)object->index; /* 1800h + n */

    if (op == DG_CO_WRITE && parameters[object->sub].check != NULL) {
        return parameters[object->sub].check(self, n, *value);
    }
    if (op == DG_CO_WRITTEN && parameters[object->sub].adopt != NULL) {
        parameters[object->sub].adopt(self, n);
    }
    return DG_CO_OK;
}

/* Parameters that do not fit together, from a damaged or foreign memory, leave a TPDO not valid. */
static void start_tpdo(struct dg_co_node *self, uint8_t n)
{
    uint32_t *cob_id = &self->value[CO_TPDO(n, CO_PDO_COB_ID)];
    uint32_t *count = &self->value[CO_TPDO(n, CO_PDO_MAPPED)];

    if (check_cob_id(self, n, *cob_id) != DG_CO_OK) {
        *cob_id |= CO_COB_INVALID;
    }
    *count = *count <= DG_CO_MAPPED_MAX ? *count : 0;
    adopt_cob_id(self, n);
    adopt_type(self, n);
}

void dg_co_pdo_start(struct dg_co_node *self)
{
    self->sync_mask = 0;
    for (uint8_t n = 0; n < DG_CO_TPDOS; n++) {
        self->tpdo[n] = (struct dg_co_tpdo){.event_at = DG_NEVER};
        start_tpdo(self, n);
    }
}
