/* SPDX-License-Identifier: MIT */
/*
 * pcap and pcapng, as Wireshark, dumpcap and tcpdump write them of SocketCAN. libpcap reads them.
 * It is loaded when such a file is opened, so that the command works without it. What of it is used
 * here has been the same since libpcap 1.5.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <inttypes.h>
#include <string.h>
#include <sys/time.h>
#include <unistd.h>

#include "drehgeber/bits.h"
#include "explain_source.h"

#define LIBRARY "libpcap.so.0.8"
#define LIBRARY_ELSEWHERE "libpcap.so.1"
#define ERROR_MAX 256u
#define NANOSECONDS 1
#define LINK_SOCKETCAN 227
#define PACKET 1
#define OVER (-2)

/* struct can_frame of Linux, the CAN-ID in the byte order of networks. */
#define HEAD_SIZE 8u
#define ID_EXTENDED 0x80000000u
#define ID_REMOTE 0x40000000u
#define ID_ERROR 0x20000000u
#define ID_MASK 0x7FFu
#define FLAGS_AT 5u
#define FLAG_FD 0x04u
#define DLC_MAX 8u

/* struct pcap_pkthdr; with nanoseconds in tv_usec, as asked for. */
struct packet {
    struct timeval at;
    uint32_t captured;
    uint32_t length;
};

/* Functions of the library. */
struct library {
    void *(*open)(FILE *file, unsigned precision, char *why);
    int (*link)(void *pcap);
    int (*next)(void *pcap, struct packet **packet, const uint8_t **bytes);
    char *(*why)(void *pcap);
    void (*close)(void *pcap);
};

#define AT(member) offsetof(struct library, member)
static const struct {
    const char *name;
    size_t at;
} functions[] = {
    {"pcap_fopen_offline_with_tstamp_precision", AT(open)},
    {"pcap_datalink", AT(link)},
    {"pcap_next_ex", AT(next)},
    {"pcap_geterr", AT(why)},
    {"pcap_close", AT(close)},
};
_Static_assert(sizeof(struct library) == DG_COUNT(functions) * sizeof(void (*)(void)),
               "a row for each function");

struct capture {
    struct explain_source source;
    void *loaded; /* the library */
    struct library library;
    FILE *file; /* its own stream of the file, which it closes */
    void *pcap;
};

static bool begins(const uint8_t *bytes, size_t n)
{
    static const uint32_t marks[] = {0x0A0D0D0A, 0xA1B2C3D4, 0xD4C3B2A1, 0xA1B23C4D, 0x4D3CB2A1};
    for (size_t i = 0; n >= sizeof marks[0] && i < DG_COUNT(marks); i++) {
        if (dg_load_le32(bytes) == marks[i]) {
            return true;
        }
    }
    return false;
}

static int load_libpcap(struct capture *self, struct lx_error *error)
{
    self->loaded = dlopen(LIBRARY, RTLD_NOW | RTLD_LOCAL);
    if (self->loaded == NULL) {
        self->loaded = dlopen(LIBRARY_ELSEWHERE, RTLD_NOW | RTLD_LOCAL);
    }
    if (self->loaded == NULL) {
        return lx_refuse(error, "expected libpcap (Debian: libpcap0.8)",
                         "%s: no libpcap, which reads such files", self->source.text.path);
    }
    for (size_t i = 0; i < DG_COUNT(functions); i++) {
        const void *found = dlsym(self->loaded, functions[i].name);
        if (found == NULL) {
            return lx_refuse(error, "expected libpcap 1.5 or newer", "%s: libpcap has no %s",
                             self->source.text.path, functions[i].name);
        }
        memcpy((char *)&self->library + functions[i].at, &found, sizeof found);
    }
    return 0;
}

static uint64_t offset_of(const struct capture *self)
{
    const off_t at = self->file == NULL ? 0 : ftello(self->file);
    return at < 0 ? 0 : (uint64_t)at;
}

/* libpcap closes the stream that it reads; the one of this source is the caller's. */
static int open_stream(struct capture *self, struct lx_error *error)
{
    const int fd = dup(fileno(self->source.text.file));
    const bool first = fd >= 0 && lseek(fd, 0, SEEK_SET) == 0;
    self->file = first ? fdopen(fd, "r") : NULL;
    if (self->file == NULL) {
        const int reason = errno;
        if (fd >= 0) {
            (void)close(fd);
        }
        return lx_fail(error, "%s: cannot read: %s", self->source.text.path, strerror(reason));
    }
    return 0;
}

static int open_capture(struct explain_source *source, struct lx_error *error)
{
    struct capture *self = (struct capture *)source;
    char why[ERROR_MAX] = "";
    if (load_libpcap(self, error) != 0 || open_stream(self, error) != 0) {
        return -1;
    }
    self->pcap = self->library.open(self->file, NANOSECONDS, why);
    if (self->pcap == NULL) {
        return lx_refuse(error, "expected a whole header", "%s:%" PRIu64 ": %s", source->text.path,
                         offset_of(self), why);
    }
    const int link = self->library.link(self->pcap);
    if (link != LINK_SOCKETCAN) {
        return lx_refuse(error, "expected 227, SocketCAN", "%s:0: packets of link type %d",
                         source->text.path, link);
    }
    return 0;
}

/* @return 1; 0: another kind of frame; -1 */
static int take_captured_frame(const uint8_t *bytes, size_t n, struct dg_can_frame *frame)
{
    if (n < HEAD_SIZE) {
        return -1;
    }
    const uint32_t id = (uint32_t)dg_load_be16(bytes) << 16 | dg_load_be16(bytes + 2);
    if ((id & (ID_EXTENDED | ID_ERROR)) != 0 || (bytes[FLAGS_AT] & FLAG_FD) != 0) {
        return 0;
    }
    frame->id = (uint16_t)(id & ID_MASK);
    frame->rtr = (id & ID_REMOTE) != 0;
    frame->dlc = bytes[4];
    if (frame->dlc > DLC_MAX || (!frame->rtr && n < HEAD_SIZE + frame->dlc)) {
        return -1;
    }
    memcpy(frame->data, bytes + HEAD_SIZE, frame->rtr ? 0 : frame->dlc);
    return 1;
}

static dg_ns time_of(const struct packet *packet)
{
    const bool fits = packet->at.tv_sec >= 0 && (uint64_t)packet->at.tv_sec < UINT64_C(10000000000);
    const bool fine = packet->at.tv_usec >= 0 && (uint64_t)packet->at.tv_usec < DG_S(1);
    return (fits ? DG_S(1) * (uint64_t)packet->at.tv_sec : 0) +
           (fine ? (uint64_t)packet->at.tv_usec : 0);
}

static int refuse_capture(const struct capture *self, uint64_t offset, const char *what,
                          const char *right, struct lx_error *error)
{
    return lx_refuse(error, right, "%s:%" PRIu64 ": %s", self->source.text.path, offset, what);
}

static int next(struct explain_source *source, struct dg_tap_event *to, struct lx_error *error)
{
    struct capture *self = (struct capture *)source;
    for (;;) {
        const uint64_t offset = offset_of(self);
        struct packet *packet;
        const uint8_t *bytes;
        const int got = self->library.next(self->pcap, &packet, &bytes);
        if (got != PACKET) {
            return got == OVER ? 0
                               : refuse_capture(self, offset, self->library.why(self->pcap),
                                                "expected a whole packet", error);
        }
        *to = (struct dg_tap_event){.kind = DG_TAP_FRAME};
        const int found = take_captured_frame(bytes, packet->captured, &to->frame);
        if (found < 0) {
            return refuse_capture(self, offset, "no CAN frame",
                                  "expected a header of 8 bytes, and up to 8 bytes of data", error);
        }
        explain_source_stamp(source, time_of(packet), to);
        source->left_out += found == 0 ? 1u : 0u;
        if (found > 0) {
            return found;
        }
    }
}

static void close_capture(struct explain_source *source)
{
    struct capture *self = (struct capture *)source;
    if (self->pcap != NULL) {
        self->library.close(self->pcap); /* and `file` */
    } else if (self->file != NULL) {
        (void)fclose(self->file);
    }
    if (self->loaded != NULL) {
        (void)dlclose(self->loaded);
    }
}

const struct explain_format explain_pcap = {
    .name = "pcap",
    .begins = begins,
    .size = sizeof(struct capture),
    .open = open_capture,
    .next = next,
    .close = close_capture,
};
