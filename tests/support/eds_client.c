/* SPDX-License-Identifier: MIT */
#include "eds_client.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/bits.h"
#include "drehgeber/host_wire.h"

static void count_note(void *ctx, const struct dg_eds_note *note)
{
    struct eds_client *self = ctx;

    assert_non_null(note->what);
    if (self->notes < EDS_CLIENT_NOTES) {
        self->kept[self->notes] = *note;
    }
    self->notes++;
    self->lacks += note->lacks ? 1u : 0u;
}

int eds_client_read(struct eds_client *self, const char *text, size_t n)
{
    const struct dg_eds_setup setup = {
        .size = sizeof setup,
        .text = text,
        .n = n,
        .memory = self->memory,
        .memory_size = sizeof self->memory,
        .note = count_note,
        .ctx = self,
    };

    self->notes = 0;
    self->lacks = 0;
    return dg_cia406_read(&self->file, &setup, &self->error);
}

bool eds_client_noted(const struct eds_client *self, const char *section, const char *what)
{
    for (unsigned i = 0; i < self->notes && i < EDS_CLIENT_NOTES; i++) {
        const struct dg_eds_note *note = &self->kept[i];
        if (strcmp(note->section, section) == 0 && strstr(note->what, what) != NULL) {
            return true;
        }
    }
    return false;
}

void eds_client_make(struct eds_client *self)
{
    const struct dg_host_wire *wire = dg_host_wire_of(&self->file.device);
    char text[8];

    assert_true(dg_host_size(&self->file.device, wire) <= sizeof self->handle);
    self->host = dg_host_init(self->handle, sizeof self->handle, &self->file.device, wire);
    assert_non_null(self->host);
    (void)snprintf(text, sizeof text, "%u", EDS_CLIENT_NODE);
    assert_int_equal(dg_host_set(self->host, "node", text), DG_HOST_OK);
    self->now = DG_S(1);
}

void eds_client_switch_on(struct eds_client *self)
{
    assert_int_equal(dg_host_power(self->host, self->now, true), DG_HOST_OK);
    self->now += DG_S(1);
    (void)dg_host_step(self->host, self->now);
}

struct dg_host_event eds_client_ask(struct eds_client *self, uint8_t command, uint16_t index,
                                    uint8_t sub, uint32_t value)
{
    struct dg_host_event event;

    while (dg_host_receive(self->host, &event) != 0) {
    }
    event = (struct dg_host_event){
        .at = self->now, .id = 0x600u + EDS_CLIENT_NODE, .kind = DG_HOST_CAN, .length = 8};
    event.data[0] = command;
    dg_store_le16(&event.data[1], index);
    event.data[3] = sub;
    dg_store_le32(&event.data[4], value);
    assert_int_equal(dg_host_send(self->host, &event), DG_HOST_OK);
    (void)dg_host_step(self->host, self->now);
    self->now += DG_MS(50);
    (void)dg_host_step(self->host, self->now);
    while (dg_host_receive(self->host, &event) > 0) {
        if (event.id == 0x580u + EDS_CLIENT_NODE) {
            return event;
        }
    }
    fail_msg("no answer for %04Xh:%u", index, sub);
    return event;
}

uint32_t eds_client_upload(struct eds_client *self, uint16_t index, uint8_t sub)
{
    const struct dg_host_event answer = eds_client_ask(self, 0x40, index, sub, 0);

    assert_int_equal(answer.data[0] & 0xE2, 0x42);
    return dg_load_le32(&answer.data[4]);
}

uint32_t eds_client_download(struct eds_client *self, uint16_t index, uint8_t sub, uint32_t value,
                             uint8_t n)
{
    const struct dg_host_event answer =
        eds_client_ask(self, (uint8_t)(0x23u + 4u * (4u - n)), index, sub, value);

    return answer.data[0] == 0x80 ? dg_load_le32(&answer.data[4]) : 0;
}
