/* SPDX-License-Identifier: MIT */
/* canopen-stack of Embedded Office. */
#include <string.h>

#include "co_core.h"
#include "peer.h"

#define ROWS_MAX 256u
#define TIMERS 16u
#define TPDO_WITHOUT_RTR 0x40000000u

static CO_OBJ od[ROWS_MAX];
static uint32_t values[ROWS_MAX];
static CO_OBJ_STR strings[ROWS_MAX];
static CO_TMR_MEM timers[TIMERS];
static uint8_t buffer[CO_SSDO_N * CO_SDO_BUF_BYTE];
static CO_EMCY_TBL errors[1];
static CO_NODE node;
static const struct peer_frame *incoming;

static void nothing(void)
{
}

static void enable(uint32_t baud)
{
    (void)baud;
}

static int16_t receive(CO_IF_FRM *frame)
{
    if (incoming == NULL) {
        return 0;
    }
    frame->Identifier = incoming->id;
    frame->DLC = incoming->dlc;
    memcpy(frame->Data, incoming->data, sizeof frame->Data);
    incoming = NULL;
    return sizeof *frame;
}

static int16_t report_frame(CO_IF_FRM *frame)
{
    from_peer((uint16_t)frame->Identifier, frame->DLC, frame->Data);
    return sizeof *frame;
}

/* A timer that counts down milliseconds. */
static uint32_t ticks;

static void reload(uint32_t number)
{
    ticks = number;
}

static uint32_t delay(void)
{
    return ticks;
}

static uint8_t update(void)
{
    return ticks > 0 && --ticks == 0;
}

static uint32_t memory(uint32_t start, uint8_t *bytes, uint32_t size)
{
    (void)start;
    (void)bytes;
    return size;
}

/* What the stack acts on; everything else is a value. */
static const CO_OBJ_TYPE *type_of(const struct row *row)
{
    static const struct {
        uint16_t from, to;
        uint8_t sub, sub_to;
        const CO_OBJ_TYPE *type;
    } types[] = {
        {0x1005, 0x1005, 0, 0, CO_TSYNC_ID},   {0x1006, 0x1006, 0, 0, CO_TSYNC_CYCLE},
        {0x1014, 0x1014, 0, 0, CO_TEMCY_ID},   {0x1017, 0x1017, 0, 0, CO_THB_PROD},
        {0x1800, 0x1803, 1, 1, CO_TPDO_ID},    {0x1800, 0x1803, 2, 2, CO_TPDO_TYPE},
        {0x1800, 0x1803, 5, 5, CO_TPDO_EVENT}, {0x1A00, 0x1A03, 0, 0, CO_TPDO_NUM},
        {0x1A00, 0x1A03, 1, 8, CO_TPDO_MAP},
    };
    for (size_t i = 0; i < sizeof types / sizeof types[0]; i++) {
        if (row->index >= types[i].from && row->index <= types[i].to && row->sub >= types[i].sub &&
            row->sub <= types[i].sub_to) {
            return types[i].type;
        }
    }
    return row->type == TYPE_STRING ? CO_TSTRING
           : row->bits == 8         ? CO_TUNSIGNED8
           : row->bits == 16        ? CO_TUNSIGNED16
                                    : CO_TUNSIGNED32;
}

static void add(size_t at, const struct row *row)
{
    const unsigned flags = (row->readable ? CO_OBJ_____R_ : 0u) |
                           (row->writable ? CO_OBJ______W : 0u) |
                           (row->mappable ? CO_OBJ____P__ : 0u);

    od[at] = (CO_OBJ){CO_KEY(row->index, row->sub, flags), type_of(row), (CO_DATA)&values[at]};
    values[at] = row->value;
    if (od[at].Type == CO_TPDO_ID) {
        values[at] |= TPDO_WITHOUT_RTR;
    } else if (od[at].Type == CO_TSTRING) {
        strings[at].Start = (uint8_t *)(uintptr_t)row->text;
        od[at].Data = (CO_DATA)&strings[at];
    }
}

/* With the identifiers of the SDO server, which it looks for there. */
static void make_dictionary(void)
{
    static const struct row server[] = {
        {0x1200, 1, TYPE_U32, 32, true, false, false, 0x600u + NODE_ID, NULL},
        {0x1200, 2, TYPE_U32, 32, true, false, false, 0x580u + NODE_ID, NULL},
    };
    size_t at = 0;

    for (size_t i = 0; i < row_count; i++) {
        if (rows[i].index > 0x1200 && od[at > 0 ? at - 1 : 0].Key < CO_DEV(0x1200, 1)) {
            add(at++, &server[0]);
            add(at++, &server[1]);
        }
        add(at++, &rows[i]);
    }
}

bool peer_start(void)
{
    static const CO_IF_CAN_DRV can = {nothing, enable, receive, report_frame, nothing, nothing};
    static const CO_IF_TIMER_DRV timer = {enable, reload, delay, nothing, nothing, update};
    static const CO_IF_NVM_DRV nvm = {nothing, memory, memory};
    static CO_IF_DRV drivers = {&can, &timer, &nvm};
    CO_NODE_SPEC spec = {.NodeId = NODE_ID,
                         .Baudrate = 250000,
                         .Dict = od,
                         .DictLen = ROWS_MAX,
                         .EmcyCode = errors,
                         .TmrMem = timers,
                         .TmrNum = TIMERS,
                         .TmrFreq = 1000,
                         .Drv = &drivers,
                         .SdoBuf = buffer};

    make_dictionary();
    CONodeInit(&node, &spec);
    if (CONodeGetErr(&node) != CO_ERR_NONE) {
        return false;
    }
    CONodeStart(&node);
    return CONodeGetErr(&node) == CO_ERR_NONE;
}

void to_peer(const struct peer_frame *frame)
{
    incoming = frame;
    CONodeProcess(&node);
}

void peer_wait(void)
{
    (void)COTmrService(&node.Tmr);
    COTmrProcess(&node.Tmr);
}

/* What the stack asks its application. */
void CONodeFatalError(void)
{
}
void COTmrLock(void)
{
}
void COTmrUnlock(void)
{
}
