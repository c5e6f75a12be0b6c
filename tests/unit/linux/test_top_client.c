/* SPDX-License-Identifier: MIT */
/* A client of the control plane that cannot begin says why and leaves nothing behind. */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cmocka.h>

#include "top_client.h"

static struct top_view view;
static char path[] = "/tmp/test_top_client.XXXXXX";

static void ignore(void *ctx)
{
    (void)ctx;
}

static int set_up(void **state)
{
    (void)state;
    view = (struct top_view){.where = ""};
    (void)strcpy(path + strlen(path) - 6, "XXXXXX");
    if (mkdtemp(path) == NULL) {
        return -1;
    }
    (void)snprintf(view.where, sizeof view.where, "unix:%s/sock", path);
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    (void)unlink(view.where + strlen("unix:"));
    return rmdir(path);
}

static int listen_there(void)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    (void)snprintf(address.sun_path, sizeof address.sun_path, "%s/sock", path);
    assert_true(fd >= 0);
    assert_int_equal(bind(fd, (const struct sockaddr *)&address, sizeof address), 0);
    assert_int_equal(listen(fd, 1), 0);
    return fd;
}

/* The leak checker looks at what these two have taken. */
static void nobody_is_there(void **state)
{
    struct lx_error error = {.right = ""};
    sd_event *event = NULL;
    (void)state;
    assert_true(sd_event_new(&event) >= 0);
    assert_null(top_client_open(event, &view, ignore, NULL, &error));
    assert_non_null(strstr(lx_error_line(&error).text, view.where));
    assert_null(sd_event_unref(event));
}

static void there_is_no_loop(void **state)
{
    struct lx_error error = {.right = ""};
    (void)state;
    const int fd = listen_there();
    assert_null(top_client_open(NULL, &view, ignore, NULL, &error));
    assert_non_null(strstr(lx_error_line(&error).text, "no event loop: "));
    const int client = accept(fd, NULL, NULL);
    char byte;
    assert_int_equal(recv(client, &byte, 1, MSG_DONTWAIT), 0); /* it has hung up */
    assert_int_equal(close(client) + close(fd), 0);
}

static void one_that_begins_ends(void **state)
{
    struct lx_error error = {.right = ""};
    sd_event *event = NULL;
    (void)state;
    assert_true(sd_event_new(&event) >= 0);
    const int fd = listen_there();
    struct top_client *client = top_client_open(event, &view, ignore, NULL, &error);
    assert_non_null(client);
    top_client_close(client);
    top_client_close(NULL);
    assert_int_equal(close(fd), 0);
    assert_null(sd_event_unref(event));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(nobody_is_there, set_up, tear_down),
        cmocka_unit_test_setup_teardown(there_is_no_loop, set_up, tear_down),
        cmocka_unit_test_setup_teardown(one_that_begins_ends, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
