/* SPDX-License-Identifier: MIT */
/* An S3684 on the second serial port, one turn in ten seconds. A drive on the other side of an
   RS485 transceiver that switches by itself sees the encoder. */
#include <Arduino.h>
#include <drehgeber/drehgeber.h>

alignas(DG_HOST_ALIGN) static uint8_t memory[8192];
static struct dg_host *encoder;

static uint64_t now_ns()
{
    static uint32_t last;
    static uint64_t us;
    const uint32_t now = micros();

    us += now - last; /* micros() begins anew after 71 minutes */
    last = now;
    return us * 1000;
}

static void on_sent(void *, const struct dg_host_event *event)
{
    Serial1.write(event->data, event->length);
}

void setup()
{
    Serial1.begin(9600, SERIAL_8E1);
    encoder = dg_host_init(memory, sizeof memory, &dg_s3684_rs485, &dg_hf_wire);
    dg_host_listen(encoder, on_sent, nullptr);
    dg_host_power(encoder, now_ns(), true);
    dg_host_shaft(encoder, now_ns(), 0, DG_TURN / 10);
}

void loop()
{
    while (Serial1.available() > 0) {
        struct dg_host_event byte = {};
        byte.at = now_ns();
        byte.kind = DG_HOST_BYTES;
        byte.flags = DG_HOST_ENDED;
        byte.length = 1;
        byte.data[0] = (uint8_t)Serial1.read();
        dg_host_send(encoder, &byte);
    }
    dg_host_step(encoder, now_ns());
}
