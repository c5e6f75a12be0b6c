/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "tty_open.h"

#include <errno.h>
#include <fcntl.h>
#include <termios.h>
#include <unistd.h>

#include "serial.h"

/* A pseudo-terminal has no parity, which Debian's C library may call an invalid argument: that it
   has the speed is what counts. */
static int configure_tty(int fd, const struct lx_uart *uart)
{
    const speed_t speed = (speed_t)lx_speed_of_baud(uart->baud);
    struct termios line;
    if (tcgetattr(fd, &line) != 0) {
        return -1;
    }
    cfmakeraw(&line);
    line.c_cflag &= (tcflag_t) ~(PARENB | PARODD | CSTOPB | CRTSCTS);
    line.c_cflag |= (tcflag_t)(CLOCAL | CREAD | (uart->parity != 'N' ? PARENB : 0) |
                               (uart->parity == 'O' ? PARODD : 0));
    line.c_cc[VMIN] = 1;
    line.c_cc[VTIME] = 0;
    if (cfsetispeed(&line, speed) != 0 || cfsetospeed(&line, speed) != 0) {
        return -1;
    }
    if ((tcsetattr(fd, TCSADRAIN, &line) != 0 && errno != EINVAL) || tcgetattr(fd, &line) != 0) {
        return -1;
    }
    errno = EINVAL;
    return cfgetospeed(&line) == speed ? 0 : -1;
}

/* What came before nobody has asked for. */
int tty_open(const char *path, const struct lx_uart *uart)
{
    const int fd = open(path, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (fd >= 0 && configure_tty(fd, uart) != 0) {
        const int reason = errno;
        (void)close(fd);
        errno = reason;
        return -1;
    }
    if (fd >= 0) {
        (void)tcflush(fd, TCIOFLUSH);
    }
    return fd;
}
