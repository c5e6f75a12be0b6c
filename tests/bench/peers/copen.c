/* SPDX-License-Identifier: MIT */
/* c-open of rt-labs: without its thread, each frame by what the thread does for it. */
#include <string.h>

#include "co_api.h"
#include "co_main.h"
#include "co_obj.h"
#include "peer.h"

#define ROWS_MAX 256u
#define TPDO_MAX 4u

void co_handle_rx(co_net_t *net);
void co_handle_periodic(co_net_t *net);

os_tick_t peer_now;
int os_object;
static co_net_t *net;
static const struct peer_frame *incoming;
static uint32_t values[ROWS_MAX];
static co_entry_t entries[ROWS_MAX];
static co_obj_t od[ROWS_MAX];
static co_default_t defaults[ROWS_MAX];

/* What the stack has of its own. */
static const co_obj_t own[] = {
    {0x1001, OTYPE_VAR, 0, OD1001, co_od1001_fn},
    {0x1003, OTYPE_ARRAY, MAX_ERRORS, OD1003, co_od1003_fn},
    {0x1005, OTYPE_VAR, 0, OD1005, co_od1005_fn},
    {0x1006, OTYPE_VAR, 0, OD1006, co_od1006_fn},
    {0x1007, OTYPE_VAR, 0, OD1007, co_od1007_fn},
    {0x100C, OTYPE_VAR, 0, OD100C, co_od100C_fn},
    {0x100D, OTYPE_VAR, 0, OD100D, co_od100D_fn},
    {0x1010, OTYPE_ARRAY, 4, OD1010, co_od1010_fn},
    {0x1011, OTYPE_ARRAY, 4, OD1011, co_od1011_fn},
    {0x1014, OTYPE_VAR, 0, OD1014, co_od1014_fn},
    {0x1015, OTYPE_VAR, 0, OD1015, co_od1015_fn},
    {0x1016, OTYPE_ARRAY, MAX_HEARTBEATS, OD1016, co_od1016_fn},
    {0x1017, OTYPE_VAR, 0, OD1017, co_od1017_fn},
    {0x1029, OTYPE_ARRAY, 1, OD1029, co_od1029_fn},
    {0x1800, OTYPE_RECORD, 6, OD1800, co_od1800_fn},
    {0x1A00, OTYPE_RECORD, MAX_PDO_ENTRIES, OD1A00, co_od1A00_fn},
};

static const co_obj_t *own_of(uint16_t index)
{
    const uint16_t first = index >= 0x1800 && index < 0x1B00 ? index & 0xFF00u : index;

    for (size_t i = 0; i < sizeof own / sizeof own[0]; i++) {
        if (own[i].index == first) {
            return &own[i];
        }
    }
    return NULL;
}

static co_entry_t entry_of(size_t at)
{
    const struct row *row = &rows[at];
    const unsigned flags = (row->readable ? OD_READ : 0u) | (row->writable ? OD_WRITE : 0u) |
                           (row->mappable ? OD_TPDO : 0u);

    values[at] = row->value;
    return (co_entry_t){row->sub,  (uint8_t)flags,
                        row->type, row->bits,
                        0,         row->text != NULL ? (void *)(uintptr_t)row->text : &values[at]};
}

/* An object for each index: the stack's own, or of the rows; what is mapped and sent are defaults.
 */
static void make_dictionary(void)
{
    size_t objects = 0;
    size_t set = 0;

    for (size_t i = 0, next; i < row_count; i = next) {
        const co_obj_t *stack = own_of(rows[i].index);
        for (next = i; next < row_count && rows[next].index == rows[i].index; next++) {
            entries[next] = entry_of(next);
            if (rows[i].index >= 0x1800 && rows[i].index < 0x1B00 && rows[next].writable &&
                (rows[next].value != 0 || rows[next].sub == 0)) {
                defaults[set++] =
                    (co_default_t){rows[next].index, rows[next].sub, rows[next].value};
            }
        }
        od[objects] = stack != NULL ? *stack
                                    : (co_obj_t){0, next == i + 1 ? OTYPE_VAR : OTYPE_RECORD,
                                                 rows[next - 1].sub, &entries[i], NULL};
        od[objects++].index = rows[i].index;
    }
}

static void on_reset(co_net_t *at)
{
    (void)at;
}

bool peer_start(void)
{
    static co_cfg_t config = {
        .node = NODE_ID, .bitrate = 250000, .od = od, .defaults = defaults, .cb_reset = on_reset};

    make_dictionary();
    net = co_init("none", &config);
    return net != NULL;
}

void to_peer(const struct peer_frame *frame)
{
    peer_now += 100;
    incoming = frame;
    co_handle_rx(net);
}

void peer_wait(void)
{
    peer_now += 1000;
    co_handle_periodic(net);
}

/* The channel. */
os_channel_t *os_channel_open(const char *name, void *callback, void *arg)
{
    (void)name;
    (void)callback;
    (void)arg;
    return &os_object;
}

int os_channel_send(os_channel_t *channel, uint32_t id, const void *data, size_t dlc)
{
    (void)channel;
    from_peer((uint16_t)(id & 0x7FFu), (uint8_t)dlc, data);
    return 0;
}

int os_channel_send_rtr(os_channel_t *channel, uint32_t id, size_t dlc)
{
    (void)channel;
    (void)id;
    (void)dlc;
    return 0;
}

int os_channel_receive(os_channel_t *channel, uint32_t *id, void *data, size_t *dlc)
{
    (void)channel;
    if (incoming == NULL) {
        return -1;
    }
    *id = incoming->id;
    *dlc = incoming->dlc;
    memcpy(data, incoming->data, 8);
    incoming = NULL;
    return 0;
}

int os_channel_set_bitrate(os_channel_t *channel, int bitrate)
{
    (void)channel;
    (void)bitrate;
    return 0;
}

int os_channel_set_filter(os_channel_t *channel, uint8_t *filter, size_t size)
{
    (void)channel;
    (void)filter;
    (void)size;
    return 0;
}

int os_channel_bus_on(os_channel_t *channel)
{
    (void)channel;
    return 0;
}

int os_channel_bus_off(os_channel_t *channel)
{
    (void)channel;
    return 0;
}

int os_channel_get_state(os_channel_t *channel, os_channel_state_t *state)
{
    (void)channel;
    memset(state, 0, sizeof *state);
    return 0;
}
