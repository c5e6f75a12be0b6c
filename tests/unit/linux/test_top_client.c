/* SPDX-License-Identifier: MIT */
/* The client of `top`: one that cannot begin says why and leaves nothing behind; what it asks a rig
   when, and what it makes of the answers, of silence and of somebody else, in virtual time. */
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

#include "timer.h"
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

/* --- a rig that answers --- */

/* The client, and the rig's end of its connection. */
struct bench {
    sd_event *event;
    struct top_client *client;
    int listener;
    int line;
    unsigned changed;
};

static void count(void *ctx)
{
    struct bench *self = ctx;
    self->changed++;
}

static void serve(const struct bench *self)
{
    while (sd_event_run(self->event, 0) > 0) {
    }
}

/* All that the client has said since. */
static void hears(const struct bench *self, const char *text)
{
    char got[4096] = "";
    serve(self);
    const ssize_t n = recv(self->line, got, sizeof got - 1u, MSG_DONTWAIT);
    assert_true(n >= 0 || text[0] == '\0');
    assert_string_equal(got, text);
}

static void says(const struct bench *self, const char *text)
{
    assert_int_equal(send(self->line, text, strlen(text), MSG_NOSIGNAL), (ssize_t)strlen(text));
    serve(self);
}

static void tick(const struct bench *self)
{
    top_client_tick(self->client, lx_now());
}

static void pass(dg_ns span)
{
    (void)lx_time_pass(lx_now() + span);
}

#define CATALOGUE "SYST:VERS?;:INST:CAT?;:SHAF:CAT?\n"
#define SURVEY(name) "SYST:VERS?;:INST:SEL \"" name "\";MOD?;WIRE?;:SHAF:NAME?\n"
#define STATE(name) "SYST:VERS?;:INST:SEL \"" name "\";:STAT?;:FAUL:ACT?\n"
#define SHAFT(name) "SYST:VERS?;:INST:SEL \"" name "\";:SHAF:POS?;VEL?\n"
#define FRAMES(name) "SYST:VERS?;:INST:SEL \"" name "\";:TRAC:LAST? 32\n"
#define END "SYST:VERS?;:TIME?;:SYST:ERR:ALL?\n"
#define NO_FRAMES "1999.0;\"\"\n"
#define AT(time) "1999.0;" time ";0,\"No error\"\n"

/* Two encoders on one shaft, of which the first one is to be seen. */
static void open_bench(struct bench *self)
{
    struct lx_error error = {.right = ""};
    *self = (struct bench){.listener = listen_there()};
    assert_true(sd_event_new(&self->event) >= 0);
    self->client = top_client_open(self->event, &view, count, self, &error);
    assert_non_null(self->client);
    self->line = accept(self->listener, NULL, NULL);
    assert_true(self->line >= 0);
    view.rows = 1;
}

static void close_bench(struct bench *self)
{
    top_client_close(self->client);
    assert_int_equal(close(self->line) + close(self->listener), 0);
    assert_null(sd_event_unref(self->event));
}

/* Up to a first round, which is answered. */
static void begin(struct bench *self)
{
    open_bench(self);
    hears(self, CATALOGUE);
    says(self, "1999.0;\"a\",\"b\";\"s\",\"t\"\n");
    tick(self);
    hears(self, SURVEY("a") SURVEY("b") STATE("a") FRAMES("a") END);
    says(self, "1999.0;\"f3668\";\"slcan:x\";\"s\"\n1999.0;\"ssi-25\";\"sim:\";\"s\"\n");
    says(self, "1999.0;power=1;\"\"\n" NO_FRAMES AT("0.5"));
}

static void a_round_is_over_when_all_of_it_is_answered(void **state)
{
    struct bench self;
    (void)state;
    open_bench(&self);
    hears(&self, CATALOGUE);
    tick(&self);
    hears(&self, ""); /* not before the last one is answered */
    says(&self, "1999.0;\"a\",\"b\";\"s\",\"t\"\n");
    assert_int_equal(self.changed, 1);
    assert_int_equal(view.encoder_count, 2);
    assert_string_equal(view.encoders[1].name, "b");
    assert_int_equal(view.encoders[1].rate, -1);
    assert_true(view.encoders[1].up && !view.encoders[1].known);
    assert_int_equal(view.shaft_count, 2);
    assert_string_equal(view.shafts[1].name, "t");
    tick(&self);
    hears(&self, SURVEY("a") SURVEY("b") STATE("a") FRAMES("a") END);
    says(&self, "1999.0;\"f3668\";\"slcan:x\";\"s\"\n1999.0;\"ssi-25\";\"sim:\";\"s\"\n");
    says(&self, "1999.0;power=1;\"\"\n" NO_FRAMES);
    assert_int_equal(self.changed, 1);
    says(&self, AT("0.5"));
    assert_int_equal(self.changed, 2);
    assert_string_equal(view.time, "0.5");
    assert_string_equal(view.encoders[0].model, "f3668");
    assert_string_equal(view.encoders[0].wire, "slcan:x");
    assert_string_equal(view.encoders[1].model, "ssi-25");
    assert_int_equal(view.encoders[0].shaft, 0);
    assert_int_equal(view.encoders[1].shaft, 0);
    assert_int_equal(view.shafts[0].encoder, 0);
    assert_true(view.shafts[1].encoder == TOP_NONE);
    tick(&self); /* what stays as it is was asked for; a shaft through the first that sits on it */
    hears(&self, SHAFT("a") STATE("a") FRAMES("a") END);
    says(&self, "1999.0;-90.000001;60.5\n1999.0;power=0;\"\"\n" NO_FRAMES AT("0.7"));
    assert_true(view.shafts[0].known && !view.shafts[1].known);
    assert_int_equal(view.shafts[0].udeg, -90000001);
    assert_int_equal(view.shafts[0].mrpm, 60500);
    close_bench(&self);
}

/* What a key has set in between counts more than what was asked before. */
static void a_shaft_that_is_held_keeps_what_a_key_has_set(void **state)
{
    struct bench self;
    (void)state;
    begin(&self);
    tick(&self);
    view.shafts[0].held = true;
    view.shafts[0].udeg = 5;
    says(&self, "1999.0;1.0;1.0\n1999.0;power=1;\"\"\n" NO_FRAMES AT("1"));
    assert_int_equal(view.shafts[0].udeg, 5);
    tick(&self);
    says(&self, "1999.0;1.0;1.0\n1999.0;power=1;\"\"\n" NO_FRAMES AT("1"));
    assert_int_equal(view.shafts[0].udeg, 1000000);
    close_bench(&self);
}

/* Only the lines of the table that are to be seen, and the frames of the one that is selected. */
static void what_is_not_to_be_seen_is_not_asked_for(void **state)
{
    struct bench self;
    (void)state;
    begin(&self);
    view.first = 1;
    view.rows = 5;
    view.selected = 1;
    tick(&self);
    hears(&self, SHAFT("a") STATE("b") FRAMES("b") END);
    close_bench(&self);
}

static void a_state_is_taken_apart(void **state)
{
    struct bench self;
    (void)state;
    begin(&self);
    assert_string_equal(view.encoders[0].faults, "-");
    tick(&self);
    says(&self, "1999.0;0;0\n1999.0;power=1,mode=operational,position=-5,leds=bus:on/err:off,"
                "errors=4200 8130,wire_up=0,sent=3;\"one\",\"two\"\n" NO_FRAMES AT("1"));
    const struct top_encoder *encoder = &view.encoders[0];
    assert_true(encoder->known && encoder->powered && !encoder->up);
    assert_string_equal(encoder->mode, "operational");
    assert_string_equal(encoder->position, "-5");
    assert_string_equal(encoder->leds, "bus:on err:off");
    assert_string_equal(encoder->errors, "4200 8130");
    assert_string_equal(encoder->more, "wire_up=0 sent=3");
    assert_string_equal(encoder->faults, "one two");
    assert_true(top_fault_active(encoder, "one") && top_fault_active(encoder, "two"));
    assert_false(top_fault_active(encoder, "on") || top_fault_active(encoder, "twos") ||
                 top_fault_active(encoder, "-"));
    tick(&self);
    says(&self, "1999.0;0;0\n1999.0;power=0,wire_up=1;\"\"\n" NO_FRAMES AT("1"));
    assert_true(!encoder->powered && encoder->up);
    assert_string_equal(encoder->more, "wire_up=1");
    close_bench(&self);
}

/* Of a whole second, or more; rounded. */
static void frames_per_second_are_counted(void **state)
{
    static const struct {
        dg_ns after;
        const char *frames;
        int64_t rate;
    } rows[] = {
        {DG_MS(500), "100", -1},  {DG_MS(500), "110", -1}, {DG_MS(500), "150", 50},
        {DG_MS(2000), "251", 51}, {DG_MS(999), "900", 51}, {DG_MS(1), "1051", 800},
        {DG_MS(1500), "1051", 0}, {DG_S(1), "5", 0}, /* it was started again */
        {DG_S(1), "6", 1},
    };
    struct bench self;
    char answer[64];
    (void)state;
    begin(&self);
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        pass(rows[i].after);
        tick(&self);
        (void)snprintf(answer, sizeof answer, "1999.0;0;0\n1999.0;frames=%s;\"\"\n",
                       rows[i].frames);
        says(&self, answer);
        says(&self, NO_FRAMES AT("1"));
        assert_int_equal(view.encoders[0].rate, rows[i].rate);
    }
    close_bench(&self);
}

static void frames_are_those_of_the_selected_encoder(void **state)
{
    struct bench self;
    char many[2048] = "1999.0;";
    (void)state;
    begin(&self);
    for (unsigned i = 0; i < TOP_FRAMES + 1u; i++) {
        char one[32];
        (void)snprintf(one, sizeof one, "%s\"frame %u\"", i == 0 ? "" : ",", i);
        (void)strcat(many, one);
    }
    tick(&self);
    says(&self, "1999.0;0;0\n1999.0;power=1;\"\"\n");
    says(&self, many);
    says(&self, "\n" AT("1"));
    assert_int_equal(view.frame_count, TOP_FRAMES);
    assert_string_equal(view.frames[0], "frame 0");
    assert_string_equal(view.frames[TOP_FRAMES - 1u], "frame 31");
    tick(&self);
    view.selected = 1; /* meanwhile */
    says(&self, "1999.0;0;0\n1999.0;power=1;\"\"\n1999.0;\"late\"\n" AT("1"));
    assert_string_equal(view.frames[0], "frame 0");
    close_bench(&self);
}

static void faults_are_those_that_were_asked_for(void **state)
{
    struct bench self;
    (void)state;
    begin(&self);
    view.faults_of = 1;
    top_client_ask_faults(self.client, 1);
    hears(&self, "SYST:VERS?;:INST:SEL \"b\";:FAUL:CAT?\n");
    says(
        &self,
        "1999.0;\"one\",BIT,\"why\",\"what; and \"\"so\"\"\",\"5.1\",\"two\",BIT,\"x\",\"y\",\"\"\n");
    assert_int_equal(view.fault_count, 2);
    assert_string_equal(view.faults[0].name, "one");
    assert_string_equal(view.faults[0].cause, "why");
    assert_string_equal(view.faults[0].effect, "what; and \"so\"");
    assert_string_equal(view.faults[1].name, "two");
    top_client_ask_faults(self.client, 0); /* but another one is to be seen */
    says(&self, "1999.0;\"three\",BIT,\"\",\"\",\"\"\n");
    assert_int_equal(view.fault_count, 2);
    hears(&self, "SYST:VERS?;:INST:SEL \"a\";:FAUL:CAT?\n");
    top_client_ask_faults(self.client, 2); /* there is no such one */
    hears(&self, "");
    close_bench(&self);
}

/* --- commands and refusals --- */

static void commands_go_to_an_encoder(void **state)
{
    struct bench self;
    (void)state;
    begin(&self);
    assert_true(top_client_do(self.client, 1, "POW OFF"));
    hears(&self, "INST:SEL \"b\";:POW OFF\n");
    assert_false(top_client_do(self.client, 2, "POW OFF"));
    assert_string_equal(view.message, "");
    (void)strcpy(view.trouble, "no answer for 3 s");
    assert_false(top_client_do(self.client, 1, "POW ON"));
    assert_string_equal(view.message, "no answer: not sent");
    hears(&self, "");
    close_bench(&self);
}

/* For five seconds. */
static void a_refusal_is_shown_for_a_while(void **state)
{
    struct bench self;
    (void)state;
    begin(&self);
    tick(&self);
    says(&self, "1999.0;0;0\n1999.0;power=1;\"\"\n" NO_FRAMES
                "1999.0;2;-221,\"Settings conflict;geared\"\n");
    assert_string_equal(view.message, "Settings conflict;geared");
    pass(DG_S(5) - 1u);
    tick(&self);
    assert_string_equal(view.message, "Settings conflict;geared");
    pass(1);
    tick(&self);
    assert_string_equal(view.message, "");
    close_bench(&self);
}

/* --- silence, and others --- */

static void a_rig_that_is_silent_is_left_after_ten_seconds(void **state)
{
    struct bench self;
    char byte;
    (void)state;
    begin(&self);
    tick(&self);
    hears(&self, SHAFT("a") STATE("a") FRAMES("a") END);
    pass(DG_S(1) - 1u);
    tick(&self);
    assert_string_equal(view.trouble, "");
    pass(1);
    tick(&self);
    assert_string_equal(view.trouble, "no answer for 1 s");
    says(&self, "1999.0;0;0\n"); /* something, and then nothing again */
    assert_string_equal(view.trouble, "");
    pass(DG_S(10) - 1u);
    tick(&self);
    assert_string_equal(view.trouble, "no answer for 9 s");
    pass(1);
    tick(&self);
    assert_string_equal(view.trouble, "no connection, trying again: no answer");
    assert_int_equal(recv(self.line, &byte, 1, MSG_DONTWAIT), 0);
    pass(DG_S(1) - 1u);
    tick(&self);
    assert_int_equal(close(self.line), 0);
    pass(1);
    tick(&self);
    self.line = accept(self.listener, NULL, NULL);
    hears(&self, CATALOGUE);
    says(&self, "1999.0;\"b\",\"c\";\n"); /* another one by now */
    assert_string_equal(view.trouble, "");
    assert_int_equal(view.encoder_count, 2);
    assert_int_equal(view.selected, 0);
    tick(&self);
    hears(&self, SURVEY("b") SURVEY("c") STATE("b") FRAMES("b") END);
    close_bench(&self);
}

static void the_selected_encoder_is_found_again(void **state)
{
    struct bench self;
    (void)state;
    begin(&self);
    view.selected = 1;
    assert_int_equal(close(self.line), 0);
    serve(&self);
    assert_string_equal(view.trouble, "no connection, trying again: Connection reset by peer");
    pass(DG_S(1));
    tick(&self);
    self.line = accept(self.listener, NULL, NULL);
    hears(&self, CATALOGUE);
    says(&self, "1999.0;\"x\",\"y\",\"b\";\"s\"\n");
    assert_int_equal(view.selected, 2);
    close_bench(&self);
}

static void somebody_else_is_left_at_once(void **state)
{
    static const struct {
        const char *line;
        const char *trouble;
    } rows[] = {
        {"\n", "no connection, trying again: that is not a control plane"},
        {"HTTP/1.1 400\n", "no connection, trying again: HTTP/1.1 400"},
        {"2000.0;\"a\";\"s\"\n", "no connection, trying again: 2000.0"},
        {"\x1b[2J\x7f~\n", "no connection, trying again: ?[2J?~"},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct bench self;
        open_bench(&self);
        says(&self, rows[i].line);
        assert_string_equal(view.trouble, rows[i].trouble);
        close_bench(&self);
        assert_int_equal(unlink(view.where + strlen("unix:")), 0);
        view.trouble[0] = '\0';
    }
}

static int own_time(void **state)
{
    (void)state;
    lx_time_own();
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(nobody_is_there, set_up, tear_down),
        cmocka_unit_test_setup_teardown(there_is_no_loop, set_up, tear_down),
        cmocka_unit_test_setup_teardown(one_that_begins_ends, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_round_is_over_when_all_of_it_is_answered, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(a_shaft_that_is_held_keeps_what_a_key_has_set, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(what_is_not_to_be_seen_is_not_asked_for, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_state_is_taken_apart, set_up, tear_down),
        cmocka_unit_test_setup_teardown(frames_per_second_are_counted, set_up, tear_down),
        cmocka_unit_test_setup_teardown(frames_are_those_of_the_selected_encoder, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(faults_are_those_that_were_asked_for, set_up, tear_down),
        cmocka_unit_test_setup_teardown(commands_go_to_an_encoder, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_refusal_is_shown_for_a_while, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_rig_that_is_silent_is_left_after_ten_seconds, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(the_selected_encoder_is_found_again, set_up, tear_down),
        cmocka_unit_test_setup_teardown(somebody_else_is_left_at_once, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, own_time, NULL);
}
