/* SPDX-License-Identifier: MIT */
/*
 * A real UART (or the slave side of somebody else's pty). Its driver does the timing and finds
 * damaged characters; a device that is unplugged is waited for.
 */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <linux/serial.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <termios.h>

#include "serial.h"

/* Device numbers of the slave sides of ptys on Linux. */
#define PTY_SLAVE_MAJOR_FIRST 136u
#define PTY_SLAVE_MAJOR_LAST 143u

/* Before a damaged character. */
#define ESCAPE 0xFFu

struct tty {
    struct lx_serial serial;
    struct lx_parmrk parmrk;
    bool passing; /* a pty under its own name, which the next pty may get */
};

static struct tty *tty_of(struct lx_serial *serial)
{
    return (struct tty *)serial;
}

bool lx_parmrk_feed(struct lx_parmrk *self, uint8_t byte, struct lx_character *out)
{
    const uint8_t seen = self->seen;
    if (seen == 0 && byte == ESCAPE) {
        self->seen = 1;
        return false;
    }
    if (seen == 1 && byte == 0) {
        self->seen = 2;
        return false;
    }
    /* After one FF, everything but 00 stands for itself; the kernel only sends FF there. */
    self->seen = 0;
    out->byte = byte;
    out->damaged = seen == 2;
    return true;
}

static size_t received(struct lx_serial *serial, dg_ns now, const uint8_t *bytes, size_t n)
{
    (void)now;
    (void)bytes;
    (void)n;
    serial->baud = serial->uart.baud;
    serial->parity = serial->uart.parity;
    return 0;
}

static bool decode(struct lx_serial *serial, uint8_t byte, struct lx_character *out)
{
    return lx_parmrk_feed(&tty_of(serial)->parmrk, byte, out);
}

/* Raw, with damaged characters marked. VMIN 1: a read that finds nothing says EAGAIN, so that 0
   always is a hang-up. */
static void make_line_raw(struct termios *line, const struct lx_uart *uart)
{
    cfmakeraw(line);
    line->c_iflag &= (tcflag_t) ~(IGNPAR | IGNBRK | BRKINT | IXON | IXOFF);
    line->c_iflag |= (tcflag_t)(INPCK | PARMRK);
    line->c_cflag &= (tcflag_t) ~(PARENB | PARODD | CSTOPB | CRTSCTS);
    line->c_cflag |= (tcflag_t)(CLOCAL | CREAD);
    if (uart->parity != 'N') {
        line->c_cflag |= (tcflag_t)PARENB;
    }
    if (uart->parity == 'O') {
        line->c_cflag |= (tcflag_t)PARODD;
    }
    line->c_cc[VMIN] = 1;
    line->c_cc[VTIME] = 0;
}

/* tcsetattr() succeeds when it could do any part, so the speed is read back. */
static int configure_port(int fd, const struct lx_uart *uart)
{
    struct termios line;
    const speed_t speed = (speed_t)lx_speed_of_baud(uart->baud);
    if (tcgetattr(fd, &line) != 0) {
        return -1;
    }
    make_line_raw(&line, uart);
    if (cfsetispeed(&line, speed) != 0 || cfsetospeed(&line, speed) != 0 ||
        tcsetattr(fd, TCSANOW, &line) != 0 || tcgetattr(fd, &line) != 0) {
        return -1;
    }
    if (cfgetospeed(&line) != speed) {
        errno = EINVAL;
        return -1;
    }
    return 0;
}

/* Where the driver switches the direction of an RS485 transceiver, let it; where it can hand over
   characters without collecting them, let it. Both are fine to miss. */
static void tune_port(int fd)
{
    struct serial_rs485 rs485;
    if (ioctl(fd, TIOCGRS485, &rs485) == 0 && (rs485.flags & SER_RS485_ENABLED) == 0) {
        rs485.flags |= SER_RS485_ENABLED | SER_RS485_RTS_ON_SEND;
        (void)ioctl(fd, TIOCSRS485, &rs485);
    }
    struct serial_struct port;
    if (ioctl(fd, TIOCGSERIAL, &port) == 0) {
        port.flags |= (int)ASYNC_LOW_LATENCY;
        (void)ioctl(fd, TIOCSSERIAL, &port);
    }
}

/* The slave side of a pty has no UART that does the timing. */
static bool is_pty(int fd)
{
    struct stat info;
    return fstat(fd, &info) == 0 && major(info.st_rdev) >= PTY_SLAVE_MAJOR_FIRST &&
           major(info.st_rdev) <= PTY_SLAVE_MAJOR_LAST;
}

static bool is_link(const char *path)
{
    struct stat info;
    return lstat(path, &info) == 0 && S_ISLNK(info.st_mode);
}

/* 0 or an errno. */
static int open_device(struct tty *self)
{
    struct lx_serial *serial = &self->serial;
    serial->fd = open(serial->address, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (serial->fd < 0 || configure_port(serial->fd, &serial->uart) != 0) {
        return errno;
    }
    (void)tcflush(serial->fd, TCIFLUSH); /* what came in before the port was set up */
    tune_port(serial->fd);
    serial->timed = !is_pty(serial->fd);
    self->passing = !serial->timed && !is_link(serial->address);
    self->parmrk = (struct lx_parmrk){0};
    return -lx_serial_watch(serial);
}

static int open_tty(struct lx_serial *serial, struct lx_error *error)
{
    char *address = serial->address;
    const int length = snprintf(address, sizeof serial->address, "%s", serial->setup.where);
    if (length < 0 || (size_t)length >= sizeof serial->address) {
        return lx_fail(error, "the path is too long");
    }
    const int reason = open_device(tty_of(serial));
    if (reason == ENOTTY) {
        return lx_refuse(error, "expected a serial port such as /dev/ttyUSB0", "not a serial port");
    }
    if (reason != 0) {
        return lx_fail(error, "cannot use it at %lu Bd 8%c1: %s", (unsigned long)serial->uart.baud,
                       serial->uart.parity, strerror(reason));
    }
    return 0;
}

static bool lasting(const struct lx_serial *serial)
{
    return !((const struct tty *)serial)->passing;
}

static void apply(struct lx_serial *serial)
{
    if (serial->fd >= 0 && configure_port(serial->fd, &serial->uart) != 0) {
        lx_complain("%s: cannot do %lu Bd 8%c1: %s", serial->address,
                    (unsigned long)serial->uart.baud, serial->uart.parity, strerror(errno));
    }
}

static const struct lx_serial_ops tty_ops = {
    .again = "looking for it once a second",
    .open = open_tty,
    .apply = apply,
    .received = received,
    .decode = decode,
    .lasting = lasting,
};

struct lx_serial *lx_tty_open(const struct lx_serial_setup *setup, struct lx_error *error)
{
    return lx_serial_make(&tty_ops, sizeof(struct tty), setup, error);
}
