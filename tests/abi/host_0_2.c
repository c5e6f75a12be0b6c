/* SPDX-License-Identifier: MIT */
/*
 * A program on host.h as 0.2.0 had it: every function with the type of then, and the example of
 * src/host/README.md of then. It is compiled with the header of today, as whoever upgrades does,
 * and with that of 0.2.0, which stands beside it as it was.
 */
#include <stdalign.h>
#include <stdio.h>
#include <string.h>

#include <drehgeber/host.h>

static alignas(DG_HOST_ALIGN) unsigned char memory[32768];

static const struct {
    const char *(*result_text)(int);
    size_t (*size)(const struct dg_device *, const struct dg_host_wire *);
    struct dg_host *(*init)(void *, size_t, const struct dg_device *, const struct dg_host_wire *);
    const char *(*name)(size_t);
    size_t (*size_of)(const char *);
    struct dg_host *(*make)(void *, size_t, const char *);
    const char *(*model)(const struct dg_host *);
    const char *(*protocol)(const struct dg_host *);
    int (*key)(const struct dg_host *, size_t, struct dg_host_key *);
    const char *(*word)(const struct dg_host *, const char *, size_t);
    int (*set)(struct dg_host *, const char *, const char *);
    int (*get)(const struct dg_host *, const char *, char *, size_t);
    size_t (*memory_size)(const struct dg_host *);
    int (*memory_copy)(const struct dg_host *, void *, size_t);
    int (*memory_load)(struct dg_host *, const void *, size_t);
    int (*memory_port)(struct dg_host *, const struct dg_nvm *);
    int (*power)(struct dg_host *, uint64_t, bool);
    bool (*powered)(const struct dg_host *);
    void (*shaft)(struct dg_host *, uint64_t, int64_t, int64_t);
    void (*shaft_of)(struct dg_host *, struct dg_shaft *);
    int (*share)(struct dg_host *, struct dg_host *);
    int64_t (*angle)(const struct dg_host *, uint64_t);
    int (*world_set)(struct dg_host *, uint64_t, const char *, int64_t);
    int (*world_get)(const struct dg_host *, const char *, int64_t *);
    int (*send)(struct dg_host *, const struct dg_host_event *);
    int (*receive)(struct dg_host *, struct dg_host_event *);
    uint32_t (*lost)(const struct dg_host *);
    void (*listen)(struct dg_host *, void (*)(void *ctx, const struct dg_host_event *event),
                   void *);
    uint64_t (*step)(struct dg_host *, uint64_t);
    uint64_t (*next)(const struct dg_host *);
    uint64_t (*step_ps)(struct dg_host *, uint64_t);
    int (*clock)(struct dg_host *, uint64_t, bool);
    int (*clock_ps)(struct dg_host *, uint64_t, bool);
    int (*frame)(struct dg_host *, uint64_t, struct dg_host_frame *);
    int (*registers_read)(struct dg_host *, uint64_t *, uint8_t, uint8_t *, size_t);
    int (*registers_write)(struct dg_host *, uint64_t *, uint8_t, const uint8_t *, size_t);
    int (*uart)(const struct dg_host *, struct dg_host_uart *);
    int (*bit_rate)(const struct dg_host *);
    int (*position)(const struct dg_host *, uint64_t, uint64_t *);
    int (*sincos)(const struct dg_host *, uint64_t, int32_t[4]);
    size_t (*state_size)(const struct dg_host *);
    int (*save)(struct dg_host *, void *, size_t);
    int (*restore)(struct dg_host *, const void *, size_t);
    size_t (*panel_size)(void);
    struct dg_host_panel *(*panel_init)(void *, size_t, struct dg_host *,
                                        const struct dg_instrument *);
    struct dg_host_panel *(*panel_make)(void *, size_t, struct dg_host *);
    int (*fault)(const struct dg_host_panel *, size_t, struct dg_host_fault *);
    int (*fault_set)(struct dg_host_panel *, uint64_t, const char *, bool);
    int (*scpi)(struct dg_host_panel *, uint64_t, const char *, char *, size_t);
    uint64_t (*panel_step)(struct dg_host_panel *, uint64_t);
} functions = {
    .result_text = dg_host_result_text,
    .size = dg_host_size,
    .init = dg_host_init,
    .name = dg_host_name,
    .size_of = dg_host_size_of,
    .make = dg_host_make,
    .model = dg_host_model,
    .protocol = dg_host_protocol,
    .key = dg_host_key,
    .word = dg_host_word,
    .set = dg_host_set,
    .get = dg_host_get,
    .memory_size = dg_host_memory_size,
    .memory_copy = dg_host_memory_copy,
    .memory_load = dg_host_memory_load,
    .memory_port = dg_host_memory_port,
    .power = dg_host_power,
    .powered = dg_host_powered,
    .shaft = dg_host_shaft,
    .shaft_of = dg_host_shaft_of,
    .share = dg_host_share,
    .angle = dg_host_angle,
    .world_set = dg_host_world_set,
    .world_get = dg_host_world_get,
    .send = dg_host_send,
    .receive = dg_host_receive,
    .lost = dg_host_lost,
    .listen = dg_host_listen,
    .step = dg_host_step,
    .next = dg_host_next,
    .step_ps = dg_host_step_ps,
    .clock = dg_host_clock,
    .clock_ps = dg_host_clock_ps,
    .frame = dg_host_frame,
    .registers_read = dg_host_registers_read,
    .registers_write = dg_host_registers_write,
    .uart = dg_host_uart,
    .bit_rate = dg_host_bit_rate,
    .position = dg_host_position,
    .sincos = dg_host_sincos,
    .state_size = dg_host_state_size,
    .save = dg_host_save,
    .restore = dg_host_restore,
    .panel_size = dg_host_panel_size,
    .panel_init = dg_host_panel_init,
    .panel_make = dg_host_panel_make,
    .fault = dg_host_fault,
    .fault_set = dg_host_fault_set,
    .scpi = dg_host_scpi,
    .panel_step = dg_host_panel_step,
};

/* What the page says that it prints: the boot-up, and 131072 as the answer to 6004h after two
 * turns. */
static const char wanted[] = "705 00\n585 02\n";

int main(void)
{
    const struct dg_host_event sdo = {.at = 1000000000,
                                      .kind = DG_HOST_CAN,
                                      .id = 0x605,
                                      .length = 8,
                                      .data = {0x40, 0x04, 0x60}};
    struct dg_host *encoder = functions.make(memory, sizeof memory, "f3668");
    struct dg_host_event event;
    char said[64];
    size_t n = 0;

    functions.set(encoder, "node", "5");
    functions.power(encoder, 0, true);
    functions.shaft(encoder, 0, 0, (int64_t)1 << 33); /* two turns a second */
    functions.send(encoder, &sdo);
    functions.step(encoder, 1000000000);
    while (n < 48 && functions.receive(encoder, &event) > 0) {
        n += (size_t)snprintf(said + n, sizeof said - n, "%03X %02X\n", (unsigned)event.id,
                              (unsigned)event.data[6]);
    }
    fwrite(said, 1, n, stdout);
    return n != strlen(wanted) || memcmp(said, wanted, n) != 0;
}
