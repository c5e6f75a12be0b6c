/* SPDX-License-Identifier: MIT */
/*
 * The masters of a rig: each is a process on one wire that asks its encoders in a circle, as a
 * drive or a PLC does, and checks every answer against the angle that the shaft has by the control
 * plane.
 *
 * usage: masters WIRE WHERE CONTROL NAME,ADDRESS,STEPS,TURNS...
 *
 * - WIRE: can, rs485, ring or biss
 * - WHERE: interface, terminal, port of the coupler on 127.0.0.1; of biss nothing: -
 * - CONTROL: path of the control socket
 * - ADDRESS: node-ID, RS485 address, first input register; hexadecimal
 *
 * A line for each change: "NAME STATE", with "ok", "silent", "garbled", "twice", "wrong ..." or
 * what the wire has to say. SIGTERM ends it with a line of figures:
 *
 *   figures WHERE exchanges=N wrong=N longest_us=N
 *
 * An answer is right when the shaft was there between the request and the answer; longest_us is the
 * longest time from the one to the other.
 */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <math.h>
#include <modbus/modbus.h>
#include <net/if.h>
#include <poll.h>
#include <signal.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#define DEVICES_MAX 16u
#define STATE_MAX 80u
#define LINE_SIZE 256u
#define NS_PER_MS INT64_C(1000000)
#define NS_PER_S INT64_C(1000000000)
#define DEGREES_PER_TURN 360.0
/* An encoder that has not answered by then is silent. */
#define PATIENCE (250 * NS_PER_MS)
#define CONTROL_PATIENCE (10 * NS_PER_S)
#define LOOKS_APART NS_PER_S

#define SYNC_PERIOD (20 * NS_PER_MS)
#define RS485_PAUSE (5 * NS_PER_MS)
#define RING_PERIOD (5 * NS_PER_MS)
#define BISS_PERIOD (20 * NS_PER_MS)

/* Who is asked, and what came of it. */
struct device {
    char name[33];
    unsigned address;
    double steps;     /* in a turn */
    double turns;     /* until the position repeats */
    double turn;      /* of the shaft at the time below */
    double per_ns;    /* turns */
    int64_t at;       /* CLOCK_MONOTONIC */
    unsigned answers; /* to the present SYNC */
    bool right;       /* all of them */
    char state[STATE_MAX];
};

struct master {
    const char *where;
    int control; /* socket */
    int fd;      /* of the wire */
    struct device device[DEVICES_MAX];
    size_t count;
    unsigned long exchanges;
    unsigned long wrong;
    int64_t longest;
};

static volatile sig_atomic_t ended;

static void on_signal(int number)
{
    (void)number;
    ended = 1;
}

static int64_t now_ns(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return now.tv_sec * NS_PER_S + now.tv_nsec;
}

static void sleep_until(int64_t at)
{
    const struct timespec end = {.tv_sec = at / NS_PER_S, .tv_nsec = at % NS_PER_S};
    (void)clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &end, NULL);
}

static void die(const char *what)
{
    (void)fprintf(stderr, "masters: %s: %s\n", what, strerror(errno));
    exit(1);
}

/* Whether there are bytes, or the end of them, before `end`. A signal does not shorten it: what has
   been asked is answered. */
static bool readable(int fd, int64_t end)
{
    int result = -1;
    do {
        const int64_t now = now_ns();
        const int64_t left = end > now ? end - now : 0;
        const struct timespec span = {.tv_sec = left / NS_PER_S, .tv_nsec = left % NS_PER_S};
        struct pollfd one = {.fd = fd, .events = POLLIN};
        result = ppoll(&one, 1, &span, NULL);
    } while (result < 0 && errno == EINTR);
    return result > 0;
}

/* --- what is said --- */

static void say(const char *name, const char *format, ...)
{
    va_list arguments;
    (void)printf("%s ", name);
    va_start(arguments, format);
    (void)vprintf(format, arguments);
    va_end(arguments);
    (void)putchar('\n');
}

/* Only a change is worth a line. */
static void become(struct device *device, const char *state)
{
    if (strcmp(device->state, state) != 0) {
        (void)snprintf(device->state, sizeof device->state, "%s", state);
        say(device->name, "%s", state);
    }
}

/* --- the shaft --- */

static size_t read_line(int fd, char *line, int64_t end)
{
    size_t n = 0;
    while (n < LINE_SIZE - 1u && readable(fd, end) && read(fd, &line[n], 1) == 1) {
        if (line[n] == '\n') {
            break;
        }
        n++;
    }
    line[n] = '\0';
    return n;
}

static void tell(int fd, const char *line)
{
    if (write(fd, line, strlen(line)) != (ssize_t)strlen(line)) {
        die("control");
    }
}

/* Where the shaft is and when: both are of the same moment, that of the line. The rig's clock is
   the monotonic one. */
static double ask_turn(const struct master *self, const struct device *device, int64_t *at)
{
    char line[LINE_SIZE];
    double degrees = 0;
    long long seconds = 0;
    long long ns = 0;
    (void)snprintf(line, sizeof line, "INST:SEL %s;:SHAF:POS?;:TIME?\n", device->name);
    const int64_t before = now_ns();
    tell(self->control, line);
    (void)read_line(self->control, line, before + CONTROL_PATIENCE);
    if (sscanf(line, "%lf;%lld.%9lld", &degrees, &seconds, &ns) != 3) {
        errno = EPROTO;
        die(line);
    }
    *at = seconds * NS_PER_S + ns;
    if (*at < before || *at > now_ns()) {
        errno = ERANGE;
        die("the rig's clock is not CLOCK_MONOTONIC");
    }
    return degrees / DEGREES_PER_TURN;
}

/* The shafts turn evenly: two looks say how fast. */
static void ask_shafts(struct master *self)
{
    for (size_t i = 0; i < self->count; i++) {
        self->device[i].turn = ask_turn(self, &self->device[i], &self->device[i].at);
    }
    sleep_until(now_ns() + LOOKS_APART);
    for (size_t i = 0; i < self->count; i++) {
        int64_t at = 0;
        const double turn = ask_turn(self, &self->device[i], &at);
        self->device[i].per_ns = (turn - self->device[i].turn) / (double)(at - self->device[i].at);
    }
}

static double steps_at(const struct device *device, int64_t at)
{
    return (device->turn + device->per_ns * (double)(at - device->at)) * device->steps;
}

/* Whether the shaft was at `position` some time from `from` to `to`, within a step. */
static bool was_at(const struct device *device, uint64_t position, int64_t from, int64_t to)
{
    const double a = steps_at(device, from);
    const double b = steps_at(device, to);
    const double low = floor(fmin(a, b)) - 1.0;
    const double range = device->steps * device->turns;
    double above = fmod((double)position - low, range);
    above += above < 0 ? range : 0;
    return above <= floor(fmax(a, b)) + 1.0 - low;
}

/* An answer that is all right but for the position in it. */
static bool check(struct master *self, struct device *device, uint64_t position, int64_t from)
{
    const int64_t to = now_ns();
    self->exchanges++;
    if (was_at(device, position, from, to)) {
        return true;
    }
    self->wrong++;
    say(device->name, "wrong %llu, not %.0f to %.0f", (unsigned long long)position,
        steps_at(device, from), steps_at(device, to));
    return false;
}

static void took(struct master *self, int64_t from)
{
    const int64_t time = now_ns() - from;
    self->longest = time > self->longest ? time : self->longest;
}

/* --- CAN: SYNC for all, then SDO for one --- */

#define ID_NMT 0x000u
#define ID_SYNC 0x080u
#define ID_EMCY 0x080u
#define ID_TPDO2 0x280u
#define ID_SDO_ANSWER 0x580u
#define ID_SDO_REQUEST 0x600u
#define ID_BOOT_UP 0x700u
#define ID_SERVICE 0x780u
#define ID_NODE 0x07Fu
#define NMT_START 0x01u
#define EMCY_BUS_OFF_OVER 0x8140u
#define UPLOADED_FOUR 0x43u

/* What is on the way of a cycle. */
struct cycle {
    int64_t sync;   /* when it went out */
    int64_t upload; /* 0: none is on the way */
    struct device *asked;
    size_t missing;
};

static void send_frame(const struct master *self, uint32_t id, const uint8_t *data, uint8_t n)
{
    struct can_frame frame = {.can_id = id, .can_dlc = n};
    memcpy(frame.data, data, n);
    if (write(self->fd, &frame, sizeof frame) != (ssize_t)sizeof frame) {
        die(self->where);
    }
}

static void start_node(const struct master *self, uint8_t node)
{
    send_frame(self, ID_NMT, (const uint8_t[]){NMT_START, node}, 2);
}

static uint32_t little_endian(const uint8_t *bytes)
{
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 |
           (uint32_t)bytes[3] << 24;
}

static void take_tpdo(struct master *self, struct cycle *cycle, struct device *device,
                      const struct can_frame *frame)
{
    const bool right = check(self, device, little_endian(frame->data), cycle->sync);
    device->right = right && (device->right || device->answers == 0);
    if (device->answers == 0) {
        cycle->missing--;
        took(self, cycle->sync);
    }
    device->answers++;
}

static void take_upload(struct master *self, struct cycle *cycle, struct device *device,
                        const struct can_frame *frame)
{
    if (cycle->upload == 0 || device != cycle->asked) {
        return;
    }
    if (frame->data[0] != UPLOADED_FOUR) {
        become(device, "garbled");
    } else {
        took(self, cycle->upload);
        (void)check(self, device, little_endian(frame->data + 4), cycle->upload);
    }
    cycle->upload = 0;
}

/* A node that was away has to be started again. */
static void take_emergency(struct master *self, struct cycle *cycle, struct device *device,
                           const struct can_frame *frame)
{
    const uint32_t code = little_endian(frame->data) & 0xFFFFu;
    (void)cycle;
    say(device->name, "emcy %04Xh", code);
    if (code == EMCY_BUS_OFF_OVER) {
        start_node(self, (uint8_t)device->address);
    }
}

static void take_boot_up(struct master *self, struct cycle *cycle, struct device *device,
                         const struct can_frame *frame)
{
    (void)cycle;
    (void)frame;
    say(device->name, "boot-up");
    start_node(self, (uint8_t)device->address);
}

static const struct {
    uint32_t id;
    void (*take)(struct master *self, struct cycle *cycle, struct device *device,
                 const struct can_frame *frame);
} services[] = {
    {ID_EMCY, take_emergency},
    {ID_TPDO2, take_tpdo},
    {ID_SDO_ANSWER, take_upload},
    {ID_BOOT_UP, take_boot_up},
};

static void take_frame(struct master *self, struct cycle *cycle, const struct can_frame *frame)
{
    for (size_t i = 0; i < sizeof services / sizeof services[0]; i++) {
        for (size_t k = 0; (frame->can_id & ID_SERVICE) == services[i].id && k < self->count; k++) {
            if (self->device[k].address == (frame->can_id & ID_NODE)) {
                services[i].take(self, cycle, &self->device[k], frame);
            }
        }
    }
}

/* Frames until `end`, or until all are there that are waited for. */
static void take_frames(struct master *self, struct cycle *cycle, int64_t end, bool all)
{
    struct can_frame frame;
    while ((all || cycle->missing > 0 || cycle->upload != 0) && readable(self->fd, end)) {
        if (read(self->fd, &frame, sizeof frame) != (ssize_t)sizeof frame) {
            die(self->where);
        }
        take_frame(self, cycle, &frame);
    }
}

static void judge(struct device *device)
{
    if (device->answers == 0) {
        become(device, "silent");
    } else if (device->answers > 1) {
        become(device, "twice");
    } else if (device->right) {
        become(device, "ok");
    }
    device->answers = 0;
}

/* Whoever did not answer to SYNC is not asked by SDO. */
static void ask_sdo(struct master *self, struct cycle *cycle, struct device *device)
{
    if (device->answers == 0) {
        return;
    }
    cycle->asked = device;
    cycle->upload = now_ns();
    send_frame(self, ID_SDO_REQUEST + device->address, (const uint8_t[8]){0x40, 0x04, 0x60}, 8);
    take_frames(self, cycle, cycle->upload + PATIENCE, false);
    if (cycle->upload != 0) {
        become(device, "silent");
    }
}

static void run_can(struct master *self)
{
    struct cycle cycle = {0};
    struct sockaddr_can address = {.can_family = AF_CAN};
    address.can_ifindex = (int)if_nametoindex(self->where);
    self->fd = socket(AF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW);
    if (self->fd < 0 || bind(self->fd, (struct sockaddr *)&address, sizeof address) != 0) {
        die(self->where);
    }
    start_node(self, 0);
    for (unsigned i = 0; ended == 0; i++) {
        cycle = (struct cycle){.sync = now_ns(), .missing = self->count};
        send_frame(self, ID_SYNC, NULL, 0);
        take_frames(self, &cycle, cycle.sync + PATIENCE, false);
        ask_sdo(self, &cycle, &self->device[i % self->count]);
        take_frames(self, &cycle, cycle.sync + SYNC_PERIOD, true);
        for (size_t k = 0; k < self->count; k++) {
            judge(&self->device[k]);
        }
    }
}

/* --- RS485: one after the other --- */

#define READ_POSITION 0x42u
#define READ_STATUS 0x50u
#define WARNING 0x80u
#define ERROR_REPLY_BYTES 4u
#define POSITION_REPLY_BYTES 7u
#define QUIET (50 * NS_PER_MS)

static bool intact(const uint8_t *bytes, size_t n)
{
    uint8_t sum = 0;
    for (size_t i = 0; i < n; i++) {
        sum ^= bytes[i];
    }
    return sum == 0;
}

/* A reply of `length` bytes, or of an error. @return its bytes; 0: nothing came */
static size_t read_reply(const struct master *self, uint8_t *bytes, size_t length, int64_t end)
{
    size_t n = 0;
    while (n < length && readable(self->fd, end)) {
        if (read(self->fd, &bytes[n], 1) != 1) {
            die(self->where);
        }
        n++;
        if (n == 2 && (bytes[1] & ~WARNING) == READ_STATUS) {
            length = ERROR_REPLY_BYTES;
        }
    }
    return n;
}

/* Until nothing comes any more. */
static void let_quiet(const struct master *self)
{
    uint8_t byte;
    while (readable(self->fd, now_ns() + QUIET)) {
        if (read(self->fd, &byte, 1) != 1) {
            die(self->where);
        }
    }
}

/* @return bytes of an intact reply, else 0 */
static size_t exchange(struct master *self, struct device *device, uint8_t command, uint8_t *reply)
{
    const uint8_t address = (uint8_t)device->address;
    const uint8_t request[] = {address, command, address ^ command};
    const size_t length = command == READ_STATUS ? ERROR_REPLY_BYTES : POSITION_REPLY_BYTES;
    const int64_t from = now_ns();
    if (write(self->fd, request, sizeof request) != (ssize_t)sizeof request) {
        die(self->where);
    }
    const size_t n = read_reply(self, reply, length, from + PATIENCE);
    if (n == 0) {
        become(device, "silent");
        return 0;
    }
    if (n < ERROR_REPLY_BYTES || reply[0] != address || !intact(reply, n)) {
        become(device, "garbled");
        let_quiet(self);
        return 0;
    }
    took(self, from);
    sleep_until(now_ns() + RS485_PAUSE);
    return n;
}

/* Why the warning bit is set, until it is not. */
static void empty_queue(struct master *self, struct device *device, uint8_t *reply)
{
    while ((reply[1] & WARNING) != 0 && exchange(self, device, READ_STATUS, reply) != 0) {
        say(device->name, "warning %02Xh", reply[2]);
    }
}

static void ask_rs485(struct master *self, struct device *device)
{
    uint8_t reply[POSITION_REPLY_BYTES];
    char text[STATE_MAX];
    const int64_t from = now_ns();
    const size_t n = exchange(self, device, READ_POSITION, reply);
    if (n == 0) {
        return;
    }
    if (n == ERROR_REPLY_BYTES) {
        (void)snprintf(text, sizeof text, "error %02Xh", reply[2]);
        become(device, text);
    } else {
        const uint64_t position = (uint64_t)reply[2] << 24 | (uint64_t)reply[3] << 16 |
                                  (uint64_t)reply[4] << 8 | reply[5];
        if (check(self, device, position, from)) {
            become(device, "ok");
        }
    }
    empty_queue(self, device, reply);
}

static void run_rs485(struct master *self)
{
    struct termios line;
    self->fd = open(self->where, O_RDWR | O_NOCTTY | O_CLOEXEC);
    if (self->fd < 0 || tcgetattr(self->fd, &line) != 0) {
        die(self->where);
    }
    cfmakeraw(&line);
    line.c_cflag |= CLOCAL | CREAD | PARENB;
    (void)cfsetspeed(&line, B9600);
    if (tcsetattr(self->fd, TCSANOW, &line) != 0) {
        die(self->where);
    }
    for (unsigned i = 0; ended == 0; i++) {
        ask_rs485(self, &self->device[i % self->count]);
    }
}

/* --- INTERBUS: the input image, between two looks at the coupler --- */

#define COUPLER_STATUS 0x100Cu
#define STATUS_BUS_ERROR 2u
#define STATUS_MODULE_ERROR 4u
#define RING_CYCLE (10 * NS_PER_MS)
#define IMAGE_WORDS 5
#define POSITION_BITS 0x01FFFFFFu
#define NO_POSITION 0x80000000u
/* IN is of the last cycle of the ring, which was due not longer ago than this. */
#define IN_AGE (2 * RING_CYCLE)

static uint16_t coupler_status(modbus_t *coupler)
{
    uint16_t status = 0;
    if (modbus_read_input_registers(coupler, COUPLER_STATUS, 1, &status) != 1) {
        die("coupler");
    }
    return status;
}

static void look_at(struct master *self, struct device *device, const uint16_t *words, int64_t from)
{
    const bool has_states = device->address == IMAGE_WORDS - 2; /* a K3 */
    const bool single = device->turns <= 1.0;
    const uint32_t value = single ? words[0] : (uint32_t)words[0] << 16 | words[1];
    if (has_states && (value & NO_POSITION) != 0) {
        become(device, "invalid");
    } else if (check(self, device, has_states ? value & POSITION_BITS : value, from - IN_AGE)) {
        become(device, "ok");
    }
}

/* A device without states in its word can only be told by the ring that it has no position. */
static void ask_ring(struct master *self, modbus_t *coupler, struct device *ring)
{
    uint16_t in[IMAGE_WORDS];
    const uint16_t before = coupler_status(coupler);
    const int64_t from = now_ns();
    if (modbus_read_input_registers(coupler, 0, IMAGE_WORDS, in) != IMAGE_WORDS) {
        die("coupler");
    }
    took(self, from);
    const uint16_t status = before | coupler_status(coupler);
    if ((status & STATUS_BUS_ERROR) != 0) {
        become(ring, "bus-error");
    } else if ((status & STATUS_MODULE_ERROR) != 0) {
        become(ring, "module-error");
    } else {
        become(ring, "ok");
        for (size_t i = 0; i < self->count; i++) {
            look_at(self, &self->device[i], &in[self->device[i].address], from);
        }
    }
}

static void run_ring(struct master *self)
{
    struct device ring = {.name = "ring"};
    modbus_t *coupler = modbus_new_tcp("127.0.0.1", atoi(self->where));
    if (coupler == NULL || modbus_connect(coupler) != 0) {
        die(self->where);
    }
    (void)modbus_set_response_timeout(coupler, 5, 0);
    for (int64_t at = now_ns(); ended == 0; at += RING_PERIOD) {
        ask_ring(self, coupler, &ring);
        at = at > now_ns() - RING_PERIOD ? at : now_ns() - RING_PERIOD;
        sleep_until(at + RING_PERIOD);
    }
    modbus_close(coupler);
    modbus_free(coupler);
}

/* --- BiSS: over the control plane --- */

/* The frame is clocked at the rig's present time, behind one that is on the wire. */
#define FRAME_TIME NS_PER_MS

static void ask_biss(struct master *self, struct device *device)
{
    char line[LINE_SIZE];
    char errors[LINE_SIZE];
    unsigned long long position = 0;
    unsigned n_err = 0;
    unsigned n_warn = 0;
    unsigned life = 0;
    unsigned crc_right = 0;
    const int64_t from = now_ns();
    tell(self->control, "BISS:FRAM?\n");
    tell(self->control, "SYST:ERR?\n");
    (void)read_line(self->control, line, from + CONTROL_PATIENCE);
    if (sscanf(line, "%llu,%u,%u,%u,%u", &position, &n_err, &n_warn, &life, &crc_right) != 5) {
        become(device, "silent");
        return;
    }
    took(self, from);
    (void)read_line(self->control, errors, from + CONTROL_PATIENCE);
    if (crc_right == 0) {
        become(device, "garbled");
    } else if (n_err == 0 || n_warn == 0) {
        become(device, n_err == 0 ? "nERR" : "nWARN");
    } else if (check(self, device, position, from)) {
        become(device, "ok");
    }
}

static void run_biss(struct master *self)
{
    char line[LINE_SIZE];
    (void)snprintf(line, sizeof line, "INST:SEL %s\n", self->device->name);
    tell(self->control, line);
    while (ended == 0) {
        ask_biss(self, self->device);
        sleep_until(now_ns() + BISS_PERIOD);
    }
}

/* --- all of them --- */

static const struct {
    const char *name;
    void (*run)(struct master *self);
} wires[] = {
    {"can", run_can},
    {"rs485", run_rs485},
    {"ring", run_ring},
    {"biss", run_biss},
};

static void connect_control(struct master *self, const char *path)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    (void)snprintf(address.sun_path, sizeof address.sun_path, "%s", path);
    self->control = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (self->control < 0 ||
        connect(self->control, (struct sockaddr *)&address, sizeof address) != 0) {
        die(path);
    }
}

static void take_device(struct master *self, const char *text)
{
    struct device *device = &self->device[self->count++];
    if (sscanf(text, "%32[^,],%x,%lf,%lf", device->name, &device->address, &device->steps,
               &device->turns) != 4) {
        errno = EINVAL;
        die(text);
    }
}

static void run(struct master *self, const char *wire)
{
    for (size_t i = 0; i < sizeof wires / sizeof wires[0]; i++) {
        if (strcmp(wires[i].name, wire) == 0) {
            wires[i].run(self);
            return;
        }
    }
    errno = EINVAL;
    die(wire);
}

int main(int argc, char **argv)
{
    struct master self = {.fd = -1};
    const struct sigaction end = {.sa_handler = on_signal, .sa_flags = SA_RESTART};
    if (argc < 5 || argc > 4 + (int)DEVICES_MAX) {
        (void)fprintf(stderr, "usage: masters WIRE WHERE CONTROL NAME,ADDRESS,STEPS,TURNS...\n");
        return 2;
    }
    (void)sigaction(SIGTERM, &end, NULL);
    (void)setvbuf(stdout, NULL, _IOLBF, 0);
    self.where = argv[2];
    connect_control(&self, argv[3]);
    for (int i = 4; i < argc; i++) {
        take_device(&self, argv[i]);
    }
    ask_shafts(&self);
    run(&self, argv[1]);
    (void)printf("figures %s exchanges=%lu wrong=%lu longest_us=%lld\n", self.where, self.exchanges,
                 self.wrong, (long long)(self.longest / (NS_PER_MS / 1000)));
    return 0;
}
