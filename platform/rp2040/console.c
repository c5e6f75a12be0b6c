/* SPDX-License-Identifier: MIT */
#include "console.h"

#include "board.h"
#include "drehgeber/control.h"
#include "drehgeber/text.h"
#include "port.h"
#include "profile.h"
#include "rp2040.h"
#include "steps.h"

#define PIN_TX 0u
#define PIN_RX 1u
#define BAUD 115200u
#define ROOM 2048u /* a power of two; whole scripts come at once */
#define RX_EMPTY (1u << 4)
#define TX_FULL (1u << 5)
#define RX_INTERRUPTS (1u << 4 | 1u << 6) /* FIFO is half full, or waits for long */

/* What the console steers: copies, see port.h. */
static struct dg_world world;
static struct dg_rig_shaft shaft = {.name = "shaft"};

static struct dg_encoder encoder;
static struct dg_encoder *encoders[] = {&encoder};
static struct dg_rig_shaft *shafts[] = {&shaft};
static const struct dg_instrument *instruments[1];
static struct dg_control control;
static bool held;

static uint32_t steps_per_turn;

static volatile char received[ROOM];
static volatile uint32_t head, tail;

void on_uart0(void);
void on_uart0(void)
{
    while (!(REG(UART0 + UART_FR) & RX_EMPTY)) {
        const char byte = (char)REG(UART0 + UART_DR);
        if (head - tail < ROOM) { /* what nobody takes is lost, and its line with it */
            received[head % ROOM] = byte;
            head = head + 1u;
        }
    }
}

static void hand_over_line(void)
{
    port_turn(&world, &shaft.shaft);
}

static void changed(struct dg_rig *rig, struct dg_encoder *of, dg_ns now)
{
    (void)rig;
    (void)of;
    (void)now;
    hand_over_line();
}

static const char *wire(struct dg_rig *rig, const struct dg_encoder *of)
{
    (void)rig;
    (void)of;
    return port_name;
}

static void look_at_encoder(struct dg_rig *rig, struct dg_encoder *of, dg_ns now)
{
    (void)rig;
    (void)of;
    (void)now;
    if (!held) {
        held = true;
        port_hold();
    }
}

static char profile_said[DG_SCPI_DETAIL_MAX + 1u];

static int profile(struct dg_rig *of, struct dg_rig_shaft *at, dg_ns now, const char *text,
                   char *detail)
{
    struct dg_text said = dg_text_in(detail, DG_SCPI_DETAIL_MAX + 1u);
    struct dg_motion motion;

    (void)of;
    if (!profile_read(&motion, text)) {
        dg_text_add(&said, PROFILE_FORMS);
        return DG_SCPI_ILLEGAL;
    }
    motion.from = dg_shaft_angle(&at->shaft, now);
    if (dg_shaft_play(&at->shaft, now, &motion) != DG_OK) {
        return DG_SCPI_RANGE;
    }
    said = dg_text_in(profile_said, sizeof profile_said);
    dg_text_add(&said, text);
    return 0;
}

static const char *profile_text(struct dg_rig *of, const struct dg_rig_shaft *at)
{
    (void)of;
    return at->shaft.course.plays ? profile_said : "steered";
}

static const struct dg_rig_ops ops = {.changed = changed,
                                      .wire = wire,
                                      .profile = profile,
                                      .profile_text = profile_text,
                                      .look = look_at_encoder};
static struct dg_rig rig = {.encoders = encoders,
                            .encoder_count = 1,
                            .shafts = shafts,
                            .shaft_count = 1,
                            .instruments = instruments,
                            .instrument_count = 1,
                            .ops = &ops};

static void put_answer(void *ctx, const char *bytes, size_t n)
{
    (void)ctx;
    for (size_t i = 0; i < n; i++) {
        while (REG(UART0 + UART_FR) & TX_FULL) {
            (void)port_loop(); /* an answer may take long */
        }
        REG(UART0 + UART_DR) = (uint8_t)bytes[i];
    }
}

void console_start(const struct dg_device *model, const struct dg_instrument *instrument,
                   struct dg_nvm nvm)
{
    const uint32_t divisor = (BOARD_HZ * 4u + BAUD / 2u) / BAUD; /* in 1/64 of 16 samples */

    dg_world_init(&world);
    dg_shaft_init(&shaft.shaft);
    instruments[0] = instrument;
    encoder = (struct dg_encoder){.name = model->name,
                                  .model = model,
                                  .instrument = instrument,
                                  .device = port_device,
                                  .world = &world,
                                  .shaft = &shaft,
                                  .nvm = nvm};
    dg_control_init(&control, &rig, put_answer, NULL);
    board_pin(PIN_TX, BOARD_UART);
    board_pin(PIN_RX, BOARD_UART);
    REG(UART0 + UART_IBRD) = divisor >> 6;
    REG(UART0 + UART_FBRD) = divisor & 63u;
    REG(UART0 + UART_LCR_H) = 3u << 5 | 1u << 4; /* 8 bits, FIFOs */
    REG(UART0 + UART_IMSC) = RX_INTERRUPTS;
    REG(UART0 + UART_CR) = 1u << 9 | 1u << 8 | 1u << 0;
    board_interrupt(IRQ_UART0, BOARD_CONSOLE);
    steps_per_turn = steps_start();
}

/* ------------------------------------------------------------ steps and edges */

#define STEPPING_NS DG_US(100)
#define STILL_NS DG_MS(2)
#define RESTS_NS DG_S(1)

static uint32_t stepped;
static dg_ns last_step;

/* The shaft goes by as many steps as have come, from wherever it is. @return when to look again */
static dg_ns follow_steps(dg_ns now)
{
    const uint32_t count = steps_count();
    const int32_t steps = (int32_t)(count - stepped);

    if (steps != 0) {
        const dg_angle angle = dg_shaft_angle(&shaft.shaft, now);
        const int64_t counts =
            dg_angle_counts(angle + DG_TURN / steps_per_turn / 2, steps_per_turn);
        stepped = count;
        last_step = now;
        (void)dg_shaft_set_position(&shaft.shaft, now,
                                    dg_angle_of_counts(counts + steps, steps_per_turn));
        hand_over_line();
    }
    return now + (dg_elapsed(now, last_step) < RESTS_NS && last_step != 0 ? STEPPING_NS : STILL_NS);
}

static void release_input(void)
{
    if (held) {
        held = false;
        port_release();
    }
}

dg_ns console_loop(void)
{
    const dg_ns now = board_now();
    const dg_ns steps = follow_steps(now);
    const dg_ns due =
        dg_earliest(steps, dg_earliest(dg_rig_step(&rig, now), dg_control_step(&control, now)));

    if (head != tail) {
        const char byte = received[tail % ROOM];
        if (dg_control_rx(&control, now, &byte, 1) == 1) { /* 0: a line is still being done */
            tail = tail + 1u;
        }
    }
    release_input();
    return head != tail ? now : due;
}
