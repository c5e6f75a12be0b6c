/* SPDX-License-Identifier: MIT */
/*
 * BiSS-C: MA comes in on pin 2, SLO goes out on pin 3. PIO0 clocks the bits, the processor has only
 * to have them ready:
 *
 *   MA   ¯|_|¯|_|¯|_|¯|_|¯|_|¯ ... ¯|_|¯|_________|¯
 *         e1  e2                         timeout
 *   flags 0                             1 (MA is low: CDM = 1) or 2
 *   SLO  ¯¯¯¯¯|___ Ack: no words yet ___|¯|CDS ...
 *
 * Machine 0 is the slave. What it shifts out of an empty OSR is 0, which is the Ack; the first bit
 * of the two words that come for a frame is its start bit. Machine 1 counts cycles since e1, so
 * that the position is that of e1 however late the interrupt is. Machine 2 leaves a word for every
 * frame that had an e2: one clock alone is no frame, and no CDM.
 */
#include "board.h"
#include "drehgeber/biss.h"
#include "flash_log.h"
#include "pio.h"
#include "port.h"

#define PIN_MA 2u
#define PIN_SLO 3u

/* Flags of PIO0. */
#define E1 (1u << 0)
#define TIMEOUT_LOW (1u << 1)
#define TIMEOUT_HIGH (1u << 2)

/* Cycles between two looks at MA. */
#define POLL 2u

/* Labels. */
enum { RISE, EDGE, HIGH, LOW = 8, STILL = 12, IDLE = 14, READY, COUNT = 27, SECOND, END = 32 };

/* X: whether there is a word. Y: looks at MA until the timeout. ISR: how many these are. */
static const uint16_t program[END] = {
    [RISE] = PIO_OUT(PIO_PINS, 1),
    [EDGE] = PIO_MOV(PIO_Y, PIO_ISR),
    [HIGH] = PIO_JMP(PIO_PIN, STILL),
    PIO_MOV(PIO_Y, PIO_ISR), /* MA falls: time to see whether there is a word */
    PIO_MOV(PIO_X, PIO_STATUS),
    PIO_JMP(PIO_X_DEC, LOW),
    PIO_JMP(PIO_NOT_OSRE, LOW),
    PIO_PULL,
    [LOW] = PIO_JMP(PIO_PIN, RISE),
    PIO_JMP(PIO_Y_DEC, LOW),
    PIO_RAISE(1),
    PIO_JMP(PIO_ALWAYS, IDLE),
    [STILL] = PIO_JMP(PIO_Y_DEC, HIGH),
    PIO_RAISE(2),
    [IDLE] = PIO_SET(PIO_PINS, 1),
    [READY] = PIO_WAIT_PIN(1, 0), /* behind CDM = 1 */
    PIO_WAIT_PIN(0, 0),
    PIO_PULL, /* what the master did not fetch is not for the next frame */
    PIO_PULL,
    PIO_MOV(PIO_OSR, PIO_NULL),
    PIO_OUT(PIO_NULL, 32),
    PIO_WAIT_PIN(1, 0), /* e1 */
    PIO_RAISE(4),
    PIO_RAISE(5),
    PIO_RAISE(0),
    PIO_SET(PIO_PINS, 1), /* after power-on it was low */
    PIO_WAIT_IRQ(4),      /* machine 1 */
    [COUNT] = PIO_JMP(PIO_X_DEC, COUNT),
    [SECOND] = PIO_WAIT_IRQ(5), /* machine 2 */
    PIO_WAIT_PIN(0, 0),
    PIO_WAIT_PIN(1, 0),
    PIO_PUSH,
};

static const struct pio_machine slave = {
    .pio = PIO0,
    .index = 0,
    .clkdiv = 1u << 16,
    .execctrl = PIN_MA << 24 | 1u, /* jump pin; STATUS: fewer than 1 word in the TX FIFO */
    .shiftctrl = 0,                /* the most significant bit first */
    .pinctrl = 1u << 26 | 1u << 20 | PIN_MA << 15 | PIN_SLO << 5 | PIN_SLO,
    .wrap_from = COUNT - 2,
    .wrap_to = EDGE,
    .start = READY,
};
static const struct pio_machine since = {.pio = PIO0,
                                         .index = 1,
                                         .clkdiv = 1u << 16,
                                         .wrap_from = COUNT,
                                         .wrap_to = COUNT - 1,
                                         .start = COUNT - 1};
static const struct pio_machine second = {.pio = PIO0,
                                          .index = 2,
                                          .clkdiv = 1u << 16,
                                          .pinctrl = PIN_MA << 15,
                                          .wrap_from = END - 1,
                                          .wrap_to = SECOND,
                                          .start = SECOND};

/* From e1 at the pin to the count that is read, beside what machine 1 has counted: its
   synchroniser, the flag, and what the processor takes between the instructions and SysTick. As the
   emulator has it; a cycle more or less is 8 ns. */
#define E1_CYCLES 8u

const void *const port_ops = NULL;
const char *const port_name = "pio:2,3";
const bool flash_log_behind = true; /* the next frame must not wait */
static uint32_t polls;

static struct dg_biss *biss(void)
{
    return port_device;
}

/* ------------------------------------------------------------ time of e1 */

static void count_again(void)
{
    pio_do(&since, PIO_MOV_NOT(PIO_X, PIO_NULL));
    pio_do(&since, PIO_JMP(PIO_ALWAYS, COUNT - 1));
}

/* @return what SysTick, which counts down, stood at */
static uint32_t count_at_e1(void)
{
    pio_do(&since, PIO_MOV(PIO_ISR, PIO_X));
    pio_do(&since, PIO_PUSH);
    const uint32_t count = REG(SYST_CVR);
    const uint32_t cycles = ~REG(PIO0 + PIO_RXF(1));

    return count + cycles + E1_CYCLES;
}

/* ------------------------------------------------------------ frames */

static bool given_up(void)
{
    return (REG(PIO0 + PIO_IRQ) & (TIMEOUT_LOW | TIMEOUT_HIGH)) != 0;
}

/* The start bit is not due before: 40 us behind e1 at most. */
static void wait_for_start(uint32_t count, dg_ns e1)
{
    const uint32_t cycles = (uint32_t)(biss()->line.start - e1) / BOARD_CYCLE_NS;

    while (((count - REG(SYST_CVR)) & BOARD_COUNT_MASK) < cycles) {
    }
}

static void begin_frame(void)
{
    const uint32_t count = count_at_e1();
    const dg_ns e1 = board_at(count);
    uint64_t bits;
    const uint8_t n = dg_biss_frame(biss(), e1, &bits);
    const uint64_t words = (uint64_t)1 << 63 | bits << (63u - n);

    if (n != 0) {
        wait_for_start(count, e1);
    }
    if (n != 0 && !given_up()) {
        REG(PIO0 + PIO_TXF(0)) = (uint32_t)(words >> 32);
        REG(PIO0 + PIO_TXF(0)) = (uint32_t)words;
    }
    count_again();
}

static dg_ns timeout(void)
{
    const dg_ns chosen = biss()->setup.model->timeout;
    const dg_ns own = biss()->timeout == 0 ? DG_BISS_TIMEOUT_NS : DG_BISS_TIMEOUT_S_NS;

    return chosen != 0 ? chosen : own;
}

/* ISR of the slave, which stops meanwhile lest it takes the word for one of a frame. OSR is as
   empty afterwards as it was. */
static void set_timeout(void)
{
    const uint32_t wanted = (uint32_t)timeout() / (BOARD_CYCLE_NS * POLL);

    if (wanted != polls) {
        polls = wanted;
        pio_run(&slave, 0);
        REG(PIO0 + PIO_TXF(0)) = polls;
        pio_do(&slave, PIO_PULL_BLOCK);
        pio_do(&slave, PIO_MOV(PIO_ISR, PIO_OSR));
        pio_do(&slave, PIO_MOV(PIO_OSR, PIO_NULL));
        pio_do(&slave, PIO_OUT(PIO_NULL, 32));
        pio_run(&slave, 1);
    }
}

/* ------------------------------------------------------------ ends of frames */

/* What a frame was to the control frame is done with a priority of its own: a write to the EEPROM
   takes as long as two frames, and those are latched meanwhile. All else that is done at the end of
   a frame is waited for, as CDS of the next one depends on it. While the EEPROM is written CDS is
   0: P, which says that the byte was accepted, and 'busy' for S. */
#define ENDS 8u /* a power of two */

struct end {
    dg_ns at;
    bool cdm;
};

static struct end ends[ENDS];
static volatile uint32_t ended, done;
static volatile bool ending, storing;

static void latch_may_come(bool may)
{
    REG(may ? NVIC_ISER : NVIC_ICER) = 1u << IRQ_PIO0_0;
}

void port_stores(void)
{
    if (ending) {
        storing = true;
        latch_may_come(true);
    }
}

/* With the priority of BOARD_WIRE. */
void on_pendsv(void);
void on_pendsv(void)
{
    for (; done != ended; done = done + 1u) {
        const struct end *end = &ends[done % ENDS];
        latch_may_come(false);
        ending = true;
        dg_biss_frame_end(biss(), end->at, end->cdm);
        set_timeout();
        ending = false;
        storing = false;
    }
    latch_may_come(true);
}

static void end_frame(bool cdm)
{
    if ((REG(PIO0 + PIO_FSTAT) & 1u << (8 + 2)) != 0) { /* there was no e2 */
        pio_do(&second, PIO_JMP(PIO_ALWAYS, SECOND));
        return;
    }
    (void)REG(PIO0 + PIO_RXF(2));
    ends[ended % ENDS] = (struct end){.at = board_now(), .cdm = cdm};
    ended = ended + 1u;
    REG(SCB_ICSR) = 1u << 28;
}

void on_pio0(void);
void on_pio0(void)
{
    const uint32_t flags = REG(PIO0 + PIO_IRQ);

    /* A frame that has begun already is behind the one that ended. */
    if ((flags & (TIMEOUT_LOW | TIMEOUT_HIGH)) != 0) {
        REG(PIO0 + PIO_IRQ) = TIMEOUT_LOW | TIMEOUT_HIGH;
        end_frame((flags & TIMEOUT_LOW) != 0);
    }
    if ((flags & E1) == 0) {
        return;
    }
    if (done != ended && !storing) {
        latch_may_come(false); /* until on_pendsv() is through */
        return;
    }
    REG(PIO0 + PIO_IRQ) = E1;
    begin_frame();
}

/* ------------------------------------------------------------ start */

static void power_slave(bool on)
{
    const bool high = !on || dg_biss_slo(biss(), false);

    pio_run(&slave, 0);
    pio_do(&slave, PIO_SET(PIO_PINS, high));
    pio_do(&slave, PIO_JMP(PIO_ALWAYS, READY));
    count_again();
    pio_run(&slave, on);
}

void port_start(void)
{
    board_pin(PIN_MA, BOARD_PIO0);
    board_pin(PIN_SLO, BOARD_PIO0);
    pio_load(PIO0, 0, program, END);
    pio_set_up(&slave);
    pio_set_up(&since);
    pio_set_up(&second);
    pio_direct(&slave, PIN_SLO);
    pio_run(&since, 1);
    pio_run(&second, 1);
    REG(PIO0 + PIO_IRQ0_INTE) = (E1 | TIMEOUT_LOW | TIMEOUT_HIGH) << 8;
    board_interrupt(IRQ_PIO0_0, BOARD_LATCH);
    REG(SCB_SHPR3) = (uint32_t)BOARD_WIRE << 22;
    power_slave(true);
    set_timeout();
}

void port_changed(void)
{
    const bool on = biss()->line.state != DG_BISS_OFF;

    if (!on || !biss()->started) { /* SLO has its level of before the first frame */
        power_slave(on);
    }
}

dg_ns port_loop(void)
{
    return DG_NEVER;
}

/* Frames are answered while flash is erased. */
bool port_idle(void)
{
    return true;
}

bool port_pause(void)
{
    return true;
}

void port_hold(void)
{
}

void port_release(void)
{
}
