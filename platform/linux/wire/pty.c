/* SPDX-License-Identifier: MIT */
/*
 * A pseudo-terminal: the encoder has the master side, whoever talks to it opens the slave side as a
 * serial port.
 */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include "serial.h"

#define PTS "/dev/pts/"

/* A C library that reads back what it has set is through with it after this time. */
#define SETTLING DG_MS(1)

/* The slave side stays open here, too: no hang-up when a master goes, and its speed can be read
   at any time. */
struct pty {
    struct lx_serial serial;
    struct lx_timer settled; /* what a client has set is in force */
    int slave;
    bool linked;
};

static struct pty *pty_of(struct lx_serial *serial)
{
    return (struct pty *)serial;
}

/*
 * A pty has no parity, and some C libraries refuse a tcsetattr() that asks for one unless something
 * else changes with it: a client that opens the port just as it left it, or sets a timeout, would
 * fail. So there always is something to change: CLOCAL, which serial clients set and a pty ignores.
 * This takes it away again, and only it: the ioctl leaves alone what a client sets meanwhile.
 */
static void keep_changeable(void *ctx, dg_ns now)
{
    const struct pty *self = ctx;
    struct termios line;
    const int off = 0;
    (void)now;
    if (tcgetattr(self->slave, &line) == 0 && (line.c_cflag & (tcflag_t)CLOCAL) != 0) {
        (void)ioctl(self->slave, TIOCSSOFTCAR, &off);
    }
}

/* Packet mode: a read begins with 0 and goes on with data, or it tells that something was set. The
   kernel strips the parity of a pty, so the speed is all there is to know. */
static size_t received(struct lx_serial *serial, dg_ns now, const uint8_t *bytes, size_t n)
{
    struct termios line;
    if (bytes[0] != TIOCPKT_DATA) {
        lx_timer_at(&pty_of(serial)->settled, dg_after(now, SETTLING));
        return n;
    }
    serial->baud = LX_BAUD_ANY;
    if (!serial->setup.any_line && tcgetattr(pty_of(serial)->slave, &line) == 0) {
        serial->baud = lx_baud_of_speed(cfgetospeed(&line));
    }
    return 1;
}

/* Remove the link, unless somebody else has put theirs there by now. */
static void remove_link(const struct pty *self)
{
    char target[PATH_MAX];
    const char *link = self->serial.setup.where;
    const ssize_t n = readlink(link, target, sizeof target - 1);
    if (n < 0) {
        return;
    }
    target[n] = '\0';
    if (strcmp(target, self->serial.address) == 0) {
        (void)unlink(link);
    }
}

static void shut_pty(struct lx_serial *serial)
{
    struct pty *self = pty_of(serial);
    if (self->linked) {
        remove_link(self);
    }
    self->linked = false;
    if (self->slave >= 0) {
        (void)close(self->slave);
    }
    self->slave = -1;
    lx_timer_close(&self->settled);
}

/* The lock on a pty's slave side that says who made this link to it: its place is the link's
   number, its length the process. The pty's number alone says nothing, a link left behind may lead
   to somebody else's. The lock belongs to the open file, not to the process: it outlives that this
   process looks at its own ptys, and is seen by it. */
static struct flock link_lock_of(const struct stat *link, pid_t owner)
{
    return (struct flock){
        .l_type = F_WRLCK,
        .l_whence = SEEK_SET,
        .l_start = (off_t)(link->st_ino & INT32_MAX) << 32,
        .l_len = owner,
    };
}

/* The process that is the encoder behind this link to `pty`, or 0. */
static pid_t link_owner_of(const char *pty, const struct stat *link)
{
    struct flock lock = link_lock_of(link, 1);
    const int fd = open(pty, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (fd < 0) {
        return 0;
    }
    const bool known = fcntl(fd, F_OFD_GETLK, &lock) == 0 && lock.l_type != F_UNLCK;
    (void)close(fd);
    return known ? (pid_t)lock.l_len : 0;
}

/* A link that leads nowhere or to a pty was left behind by a run that could not clean up, unless
 * an encoder still runs there. */
static int clear_link(const char *link, const struct stat *info, struct lx_error *error)
{
    char target[PATH_MAX];
    const ssize_t n = S_ISLNK(info->st_mode) ? readlink(link, target, sizeof target - 1) : -1;
    const bool to_pty = n >= 0 && strncmp(target, PTS, strlen(PTS)) == 0;
    if (n < 0 || (!to_pty && access(link, F_OK) == 0)) {
        return lx_refuse(error, "remove it or give another name",
                         "exists and is not a link to a pty");
    }
    target[n] = '\0';
    const pid_t owner = to_pty ? link_owner_of(target, info) : 0;
    if (owner != 0) {
        return lx_refuse(error, "give another name", "in use by process %ld", (long)owner);
    }
    (void)unlink(link);
    return 0;
}

static int make_link(struct pty *self, struct lx_error *error)
{
    const char *link = self->serial.setup.where;
    struct stat info;
    if (lstat(link, &info) == 0 && clear_link(link, &info, error) != 0) {
        return -1;
    }
    if (symlink(self->serial.address, link) != 0) {
        return lx_fail(error, "cannot make the link: %s", strerror(errno));
    }
    self->linked = true;
    if (lstat(link, &info) == 0) {
        struct flock lock = link_lock_of(&info, getpid());
        (void)fcntl(self->slave, F_OFD_SETLK, &lock);
    }
    return 0;
}

/* Raw, and at the speed the encoder will have: a client that never sets one works. EXTPROC makes
   packet mode tell about every tcsetattr(); it does nothing else to raw bytes. */
static int prepare_slave(struct pty *self)
{
    struct termios line;
    if (tcgetattr(self->slave, &line) != 0) {
        return -1;
    }
    cfmakeraw(&line);
    line.c_lflag |= (tcflag_t)EXTPROC;
    line.c_cflag |= (tcflag_t)CREAD;
    line.c_cflag &= (tcflag_t)~CLOCAL; /* see keep_changeable() */
    const speed_t speed = (speed_t)lx_speed_of_baud(self->serial.setup.found_baud);
    if (cfsetispeed(&line, speed) != 0 || cfsetospeed(&line, speed) != 0) {
        return -1;
    }
    return tcsetattr(self->slave, TCSANOW, &line);
}

/* Packet mode begins when the slave is as it should be: nothing about it waits to be read then. */
static int open_pair(struct pty *self)
{
    struct lx_serial *serial = &self->serial;
    const int on = 1;
    serial->fd = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (serial->fd < 0 || grantpt(serial->fd) != 0 || unlockpt(serial->fd) != 0 ||
        ptsname_r(serial->fd, serial->address, sizeof serial->address) != 0) {
        return -1;
    }
    self->slave = open(serial->address, O_RDWR | O_NOCTTY | O_CLOEXEC);
    if (self->slave < 0 || prepare_slave(self) != 0) {
        return -1;
    }
    return ioctl(serial->fd, TIOCPKT, &on);
}

static int open_pty(struct lx_serial *serial, struct lx_error *error)
{
    struct pty *self = pty_of(serial);
    self->slave = -1;
    if (lx_timer_make(&self->settled, serial->setup.event, keep_changeable, self, error) != 0) {
        return -1;
    }
    if (open_pair(self) != 0) {
        const char *right = errno == ENOSPC ? "raise kernel.pty.max" : lx_more_of(errno);
        return lx_refuse(error, right, "cannot make a pty: %s", strerror(errno));
    }
    const int result = lx_serial_watch(serial);
    if (result < 0) {
        return lx_fail(error, "cannot watch the pty: %s", strerror(-result));
    }
    return serial->setup.where == NULL ? 0 : make_link(self, error);
}

/* Gone: only when the pty system itself fails, the slave side is never closed before the other one.
 */
static const struct lx_serial_ops pty_ops = {
    .again = "making another one as soon as possible",
    .open = open_pty,
    .received = received,
    .shut = shut_pty,
};

struct lx_serial *lx_pty_open(const struct lx_serial_setup *setup, struct lx_error *error)
{
    return lx_serial_make(&pty_ops, sizeof(struct pty), setup, error);
}
