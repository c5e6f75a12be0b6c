/* SPDX-License-Identifier: MIT */
/* Settings: every row reaches its place and refuses what is out of range; errors on their way. */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "engine.h"
#include "plan_rig.h"
#include "stacks.h"
#include "station_rig.h"
#include "wire.h"
#include "wire_list.h"

#define ROOM 1024u

/* An encoder's settings and world, its end of the line, and what of it is the port's. */
struct bench {
    const struct dg_device *device;
    _Alignas(max_align_t) uint8_t settings[ROOM];
    struct dg_world world;
    struct dg_engine_end end;
    dg_ns own;
};

static struct bench bench_of(const char *model)
{
    struct bench self = {.device = dg_device_find(model)};
    assert_non_null(self.device);
    assert_true(lx_stack_of(self.device)->handle->settings_size <= ROOM);
    lx_stack_deliver(lx_stack_of(self.device), self.device, self.settings);
    dg_world_init(&self.world);
    self.end = dg_engine_end_usual;
    return self;
}

static int set_value(const struct dg_key *key, void *base, const char *value,
                     struct lx_error *error)
{
    char right[128];
    struct dg_text text = dg_text_in(right, sizeof right);
    if (dg_key_set(key, base, value) == DG_OK) {
        return 0;
    }
    dg_key_say_right(key, &text);
    return lx_refuse(error, right, "%s", "");
}

/* KEY=VALUE, of all that there is of an encoder. @return 0 or -1 with `error` */
static int set_key(struct bench *self, const char *assignment, struct lx_error *error)
{
    void *const bases[LX_STACK_LISTS] = {&self->end, &self->own, self->settings, &self->world};
    const size_t n = strcspn(assignment, "=");
    struct lx_keys lists[LX_STACK_LISTS];
    lx_stack_keys(lx_stack_of(self->device), self->device, NULL, NULL, lists);
    for (size_t i = 0; i < LX_STACK_LISTS; i++) {
        for (size_t j = 0; j < lists[i].count; j++) {
            const struct dg_key *row = lx_keys_row(&lists[i], j);
            if (row != NULL && strlen(row->name) == n && strncmp(row->name, assignment, n) == 0) {
                return set_value(row, bases[i], assignment + n + 1, error);
            }
        }
    }
    fail_msg("%s: no such key", assignment);
    return -1;
}

static void set(struct bench *self, const char *assignment)
{
    struct lx_error error;
    if (set_key(self, assignment, &error) != 0) {
        fail_msg("%s: %s", assignment, lx_error_line(&error).text);
    }
}

static void refuse(struct bench *self, const char *assignment, const char *right)
{
    const struct bench before = *self;
    struct lx_error error;
    assert_int_equal(set_key(self, assignment, &error), -1);
    assert_string_equal(lx_error_line(&error).text, right);
    assert_memory_equal(&before, self, sizeof before);
}

/* --- the rows --- */

static void check_row(const struct dg_key *key, size_t size)
{
    assert_true(key->name[0] != '\0' && key->help[0] != '\0' && key->unit != NULL);
    assert_true(key->type < DG_KEY_TYPE_COUNT && key->min <= key->max && key->factor > 0);
    assert_true(key->type == DG_KEY_NS || key->factor == 1); /* nobody reads it there */
    assert_true(key->offset < size);
    assert_true(key->type != DG_KEY_FLAG || (key->words != NULL && key->max == 1));
    assert_true(key->type != DG_KEY_WORD || (key->words != NULL && key->min == 0));
}

/* It says of the same member what the core's row says, and takes no more. */
static void check_instead(const struct lx_stack *stack)
{
    if (stack->instead == NULL) {
        return;
    }
    const struct dg_key *row = dg_keys_find(stack->handle->keys, stack->instead->name);
    assert_non_null(row);
    check_row(stack->instead, stack->handle->settings_size);
    assert_true(row->offset == stack->instead->offset && row->type == stack->instead->type &&
                row->factor == stack->instead->factor);
    assert_true(row->min <= stack->instead->min && row->max >= stack->instead->max);
}

static void rows_are_whole(void **state)
{
    (void)state;
    for (size_t i = 0; i < lx_stack_count; i++) {
        const struct lx_stack *stack = lx_stacks[i];
        for (size_t j = 0; j < stack->own.count; j++) {
            check_row(&stack->own.rows[j], sizeof(dg_ns));
        }
        for (size_t j = 0; j < stack->handle->keys->count; j++) {
            check_row(&stack->handle->keys->rows[j], stack->handle->settings_size);
        }
        check_instead(stack);
        assert_non_null(dg_plan_find_kind(stack->wire, strlen(stack->wire)));
        assert_true(
            dg_plan_carries(dg_plan_find_kind(stack->wire, strlen(stack->wire)), stack->core));
    }
    for (size_t i = 0; i < DG_MEDIUM_COUNT; i++) {
        for (size_t j = 0; j < dg_engine_end_keys[i].count; j++) {
            check_row(&dg_engine_end_keys[i].rows[j], sizeof(struct dg_engine_end));
        }
    }
    for (size_t i = 0; i < dg_world_keys.count; i++) {
        check_row(&dg_world_keys.rows[i], sizeof(struct dg_world));
    }
    for (size_t i = 0; i < dg_device_count; i++) {
        assert_int_equal(lx_stack_of(dg_devices[i])->core, dg_devices[i]->stack);
    }
}

/* How many of the lists' rows are called so. */
static size_t called(const struct lx_keys *lists, const char *name)
{
    size_t n = 0;
    for (size_t i = 0; i < LX_STACK_LISTS; i++) {
        for (size_t j = 0; j < lists[i].count; j++) {
            const struct dg_key *row = lx_keys_row(&lists[i], j);
            n += row != NULL && strcmp(row->name, name) == 0 ? 1u : 0u;
        }
    }
    return n;
}

/* No encoder has a name twice, and none that its wires have, too. */
static void names_are_unique(void **state)
{
    (void)state;
    for (size_t i = 0; i < dg_device_count; i++) {
        struct lx_keys lists[LX_STACK_LISTS];
        const struct lx_stack *stack = lx_stack_of(dg_devices[i]);
        lx_stack_keys(stack, dg_devices[i], NULL, NULL, lists);
        for (size_t j = 0; j < LX_STACK_LISTS * DG_QUANTITY_COUNT * 2u; j++) {
            const struct dg_key *row = lx_keys_row(&lists[j % LX_STACK_LISTS], j / LX_STACK_LISTS);
            assert_true(row == NULL || called(lists, row->name) == 1);
            for (size_t k = 0; row != NULL && k < dg_plan_wire_count; k++) {
                assert_false(dg_plan_carries(&dg_plan_wires[k], stack->core) &&
                             dg_plan_wire_has(&dg_plan_wires[k], row->name));
            }
        }
    }
}

/* Limits are taken, what is beyond them is not. */
static void check_limits(struct bench *self, const struct dg_key *key)
{
    char text[64];
    struct lx_error error;
    if (key->type == DG_KEY_TEXT || key->type == DG_KEY_DIGITS || key->type == DG_KEY_FLAG ||
        key->type == DG_KEY_WORD) {
        return;
    }
    const int64_t values[] = {key->min, key->max, key->min - 1, key->max + 1};
    const long long one = key->places == 3 ? 1000 : 1;
    for (size_t i = 0; i < DG_COUNT(values); i++) {
        const long long value = (long long)values[i];
        (void)snprintf(text, sizeof text, "%s=%s%lld.%03lld", key->name, value < 0 ? "-" : "",
                       llabs(value) / one, one == 1 ? 0 : llabs(value) % one);
        if (one == 1) {
            *strrchr(text, '.') = '\0';
        }
        const int result = set_key(self, text, &error);
        assert_int_equal(result, i < 2 ? 0 : -1);
    }
}

static void limits_of_every_row(void **state)
{
    (void)state;
    for (size_t i = 0; i < dg_device_count; i++) {
        struct bench self = bench_of(dg_devices[i]->name);
        struct lx_keys lists[LX_STACK_LISTS];
        lx_stack_keys(lx_stack_of(self.device), self.device, NULL, NULL, lists);
        for (size_t j = 0; j < LX_STACK_LISTS; j++) {
            for (size_t k = 0; k < lists[j].count; k++) {
                if (lx_keys_row(&lists[j], k) != NULL) {
                    check_limits(&self, lx_keys_row(&lists[j], k));
                }
            }
        }
    }
}

/* --- each kind of value --- */

static void values_reach_their_place(void **state)
{
    static const char *const assignments[] = {
        "pace=0",
        "line=any",
        "reaction_us=2500",
        "init_ms=20",
        "periods=1024",
        "steps=16",
        "turns=65536",
        "memory=22",
        "implemented=23",
        "type=FFh",
        "version=v2",
        "temperature_min=-25",
        "temperature=-12.5",
        "sin_offset_permille=-7",
        "led_current_ua=31000",
        "singleturn_ok=0",
    };
    struct bench self = bench_of("s3684-rs485");
    const struct dg_hf_settings *settings = (const void *)self.settings;
    (void)state;
    assert_true(self.end.pace && !self.end.any_line);
    for (size_t i = 0; i < DG_COUNT(assignments); i++) {
        set(&self, assignments[i]);
    }
    assert_false(self.end.pace);
    assert_true(self.end.any_line);
    assert_true(settings->model.reaction == DG_US(2500) && settings->model.init == DG_MS(20));
    assert_int_equal(settings->model.periods_per_turn, 1024);
    assert_int_equal(settings->model.steps_per_period, 16);
    assert_int_equal(settings->model.turns, 65536);
    assert_int_equal(settings->model.memory_blocks, 22);
    assert_int_equal(settings->model.implemented_blocks, 23);
    assert_int_equal(settings->model.type_code, 0xFF);
    assert_string_equal(settings->model.version, "v2");
    assert_int_equal(settings->model.temperature_min_degc, -25);
    assert_int_equal(self.world.temperature_mdegc, -12500);
    assert_int_equal(self.world.sin_offset_permille, -7);
    assert_int_equal(self.world.led_current_ua, 31000);
    assert_false(self.world.singleturn_ok);
}

static void what_is_out_of_range_is_refused(void **state)
{
    static const char *const rows[][2] = {
        {"pace=2", "expected 0 or 1"},
        {"line=mine", "expected own or any"},
        {"line=", "expected own or any"},
        {"periods=0", "expected a number in 1..65535"},
        {"periods=65536", "expected a number in 1..65535"},
        {"periods=1.5", "expected a number in 1..65535"},
        {"periods=", "expected a number in 1..65535"},
        {"periods=1e3", "expected a number in 1..65535"},
        {"memory=113", "expected a number in 1..112 blocks"},
        {"type=100h", "expected a number in 0..255"},
        {"temperature=1000.001", "expected a number in -273..1000 degC with at most 3 decimals"},
        {"temperature=1.0001", "expected a number in -273..1000 degC with at most 3 decimals"},
        {"date=1207201", "expected 8 characters"},
        {"version=12345678901234567890", "expected 0 to 19 characters"},
        {"steps=16777217", "expected a number in 1..16777216"},
        {"init_ms=-1", "expected a number in 0..600000 ms"},
    };
    struct bench self = bench_of("s3684-rs485");
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        refuse(&self, rows[i][0], rows[i][1]);
    }
}

static void one_of_several_words(void **state)
{
    static const char *const words[] = {"none", "even", "odd"};
    static const struct dg_key key = {"parity", "", 1, DG_KEY_WORD, 0,
                                      1,        0,  2, words,       "the last bit"};
    uint8_t bytes[3] = {9, 9, 9};
    const struct lx_keys keys = {.rows = &key, .count = 1, .base = bytes};
    struct lx_error error;
    char *help = NULL;
    size_t size = 0;
    (void)state;
    for (uint8_t i = 0; i < DG_COUNT(words); i++) {
        assert_int_equal(set_value(&key, bytes, words[i], &error), 0);
        assert_int_equal(bytes[1], i);
    }
    assert_int_equal(set_value(&key, bytes, "mark", &error), -1);
    assert_string_equal(lx_error_line(&error).text, "expected none, even or odd");
    assert_int_equal(bytes[0], 9);
    assert_int_equal(bytes[2], 9);
    FILE *to = open_memstream(&help, &size);
    assert_non_null(to);
    lx_keys_help(&keys, to);
    assert_int_equal(fclose(to), 0);
    assert_string_equal(
        help, "  parity                  the last bit (none, even or odd, default odd)\n");
    free(help);
}

/* Help is about the keys of this list only, in their order, in place of one of the same name. */
static void help_leaves_out_what_is_not_there(void **state)
{
    static const char *const words[] = {"off", "on"};
    static const struct dg_key rows[] = {
        {"one", "", 0, DG_KEY_FLAG, 0, 1, 0, 1, words, "the first"},
        {"two", "", 1, DG_KEY_FLAG, 0, 1, 0, 1, words, "the second"},
        {"three", "", 2, DG_KEY_FLAG, 0, 1, 0, 1, words, "the third"},
    };
    static const struct dg_key other = {"three", "", 2, DG_KEY_FLAG, 0, 1, 0, 1, words, "another"};
    const struct lx_keys keys = {.rows = rows, .count = 3, .without = 1u << 1, .instead = &other};
    char *help = NULL;
    size_t size = 0;
    (void)state;
    FILE *to = open_memstream(&help, &size);
    assert_non_null(to);
    lx_keys_help(&keys, to);
    assert_int_equal(fclose(to), 0);
    assert_string_equal(help, "  one                     the first (off or on)\n"
                              "  three                   another (off or on)\n");
    free(help);
}

static void serial_numbers_get_zeros_in_front(void **state)
{
    static const char *const bad[] = {"", "1234567890", "12a", "-1"};
    struct bench self = bench_of("s3684-rs485");
    const struct dg_hf_settings *settings = (const void *)self.settings;
    const struct dg_key *serial = dg_keys_find(&dg_hf_keys, "serial");
    struct lx_error error;
    (void)state;
    assert_int_equal(set_value(serial, self.settings, "4711", &error), 0);
    assert_string_equal(settings->model.serial, "000004711");
    assert_int_equal(set_value(serial, self.settings, "987654321", &error), 0);
    assert_string_equal(settings->model.serial, "987654321");
    for (size_t i = 0; i < DG_COUNT(bad); i++) {
        assert_int_equal(set_value(serial, self.settings, bad[i], &error), -1);
        assert_string_equal(lx_error_line(&error).text, "expected 1 to 9 digits");
    }
    assert_string_equal(settings->model.serial, "987654321");
}

static void figures_have_to_fit_each_other(void **state)
{
    struct bench self = bench_of("s3684-rs485");
    struct lx_error error;
    (void)state;
    set(&self, "turns=65536");
    assert_int_equal(lx_hf_stack.check(self.settings, &error), 0); /* 2^32 */
    set(&self, "turns=65537");
    assert_int_equal(lx_hf_stack.check(self.settings, &error), -1);
    set(&self, "turns=1");
    set(&self, "steps=8192");
    assert_int_equal(lx_hf_stack.check(self.settings, &error), 0); /* 2^24 a turn */
    set(&self, "steps=8193");
    assert_int_equal(lx_hf_stack.check(self.settings, &error), -1);
    assert_non_null(strstr(lx_error_line(&error).text, "at most 16777216"));
    set(&self, "steps=512");
    set(&self, "implemented=111");
    assert_int_equal(lx_hf_stack.check(self.settings, &error), -1);
    assert_non_null(strstr(lx_error_line(&error).text, "112..128"));
    set(&self, "implemented=112");
    assert_int_equal(lx_hf_stack.check(self.settings, &error), 0);
}

static void settings_of_an_interbus_encoder(void **state)
{
    static const char *const assignments[] = {
        "steps=8192",
        "turns=16",
        "steps_minus_one=1",
        "temperature_sensor=0",
        "loop=1",
        "param_cycles=7",
        "self_test_ms=1000",
        "version=0x1FFFFFF",
        "eeprom_acknowledges=0",
    };
    struct bench k3 = bench_of("ocd-ib-k3");
    struct bench k1 = bench_of("ocd-ib-k1");
    struct lx_error error;
    (void)state;
    for (size_t i = 0; i < DG_COUNT(assignments); i++) {
        set(&k3, assignments[i]);
    }
    set(&k1, "turns=16"); /* as one of a ring, which leaves them: test_ring_bus.c */
    assert_int_equal(
        set_value(dg_keys_find(&dg_ib_keys, "serial"), k3.settings, "33554432", &error), -1);
    assert_int_equal(
        set_value(dg_keys_find(&dg_ib_keys, "serial"), k3.settings, "33554431", &error), 0);
    const struct dg_ib_model *model = (const void *)k3.settings;
    assert_int_equal(model->steps, 8192);
    assert_int_equal(model->turns, 16);
    assert_true(model->steps_minus_one && !model->temperature_sensor && model->loop);
    assert_int_equal(model->param_cycles, 7);
    assert_int_equal(model->self_test, DG_S(1));
    assert_int_equal(model->version, 0x1FFFFFF);
    assert_int_equal(model->serial, 33554431);
    assert_false(k3.world.eeprom_acknowledges);
}

/* --- which keys there are --- */

/* What is said of key=1 of an encoder on `wire`. */
static struct lx_error refused_key(const char *model, const char *wire, const char *assignment)
{
    struct dg_plan plan;
    struct lx_engine engine;
    struct lx_error error;
    const struct dg_plan_wire_kind *kind = dg_plan_find_kind(wire, strlen(wire));
    plan_rig_begin(&plan, "wire", kind, kind->usual);
    assert_int_equal(dg_plan_add_encoder(&plan, "a", dg_device_find(model), 0, 0), 0);
    assert_int_equal(lx_plan_add_assignment(&plan.encoders[0].settings, assignment, 0, &error), 0);
    const struct lx_engine_setup setup = station_setup(&plan, NULL, NULL);
    assert_int_equal(lx_engine_make(&engine, &setup, &error), -1);
    lx_engine_close(&engine);
    plan_rig_free(&plan);
    return error;
}

/* The keys that a mistyped one is answered with, of an encoder on `wire`. */
static void assert_keys(const char *model, const char *wire, const char *right)
{
    const struct lx_error error = refused_key(model, wire, "nokey=1");
    assert_string_equal(error.where.key, "nokey");
    assert_string_equal(error.right, right);
}

#define SENSES                                                                                     \
    " temperature led_current_ua supply_mv battery_mv sin_amplitude_permille "                     \
    "cos_amplitude_permille sin_offset_permille cos_offset_permille singleturn_ok "                \
    "multiturn_amplitude_ok multiturn_sync_ok multiturn_vector_ok eeprom_acknowledges "            \
    "watchdog_fired"

static void a_mistyped_key_names_those_of_the_encoder(void **state)
{
    (void)state;
    assert_keys("s3684-biss", "sim",
                "valid: mt st lc autostore busy_us busy_jitter_us sl_low_at_start hint_us "
                "stop_bit eeprom_read_us eeprom_write_us timeout_us init_ms" SENSES
                "; of the wire: clock_hz line_delay_ns compensate");
    assert_keys("f3668", "slcan", "valid: mt_bits" SENSES "; of the wire: pace");
    assert_keys("f3658", "can", "valid:" SENSES "; of the wire: pace");
    assert_keys("s3674-rs485", "pty",
                "valid: pace line sincos_us reaction_us init_ms periods steps turns memory "
                "implemented type option version date designation temperature_min temperature_max "
                "led_min_ma led_max_ma speed_max_rpm" SENSES);
    assert_keys("ocd-ib-k3", "modbus",
                "valid: steps turns steps_minus_one temperature_sensor loop param_cycles "
                "self_test_ms version temperature singleturn_ok multiturn_amplitude_ok "
                "multiturn_sync_ok multiturn_vector_ok eeprom_acknowledges; of the wire: cycle "
                "tear break_at");
}

/* Wires that have it themselves, or carry what has it; a key that only encoders have is mistyped.
 */
static void a_key_of_another_wire_names_those_that_have_it(void **state)
{
    char paced[200];
    const struct {
        const char *model;
        const char *wire;
        const char *assignment;
        const char *line;
    } rows[] = {
        {"f3668", "slcan", "clock_hz=1", "clock_hz=1: only a sim wire has it; leave it out"},
        {"s3684-rs485", "pty", "tear=1", "tear=1: only a modbus wire has it; leave it out"},
        {"s3684-biss", "sim", "pace=1", paced},
    };
    (void)state;
    (void)snprintf(paced, sizeof paced, "pace=1: only %s wires have it; leave it out",
                   list_wires(DG_PLAN_CARRIES(CHARACTERS) | DG_PLAN_CARRIES(FRAMES), ", "));
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        const struct lx_error error = refused_key(rows[i].model, rows[i].wire, rows[i].assignment);
        assert_string_equal(lx_error_line(&error).text, rows[i].line);
    }
    const struct lx_error error = refused_key("f3668", "slcan", "reaction_us=1");
    assert_string_equal(error.what, "no such key");
}

/* --- errors --- */

static void whoever_is_nearest_says_where(void **state)
{
    struct lx_error error;
    (void)state;
    assert_int_equal(lx_refuse(&error, "expected 2", "%s is wrong", "1"), -1);
    assert_string_equal(lx_error_line(&error).text, "1 is wrong; expected 2");
    assert_int_equal(lx_about(&error, LX_ABOUT_SETTING, "a", "1"), -1);
    assert_int_equal(lx_about(&error, LX_ABOUT_WIRE, "pty", "x"), -1);
    assert_string_equal(lx_error_line(&error).text, "a=1: 1 is wrong; expected 2");
    assert_int_equal(lx_stands(&error, NULL, 3), -1);
    assert_int_equal(lx_stands(&error, "r.ini", 4), -1);
    assert_int_equal(lx_stands(&error, "r.ini", 5), -1);
    assert_string_equal(lx_error_line(&error).text, "r.ini:4: a=1: 1 is wrong; expected 2");
    assert_string_equal(lx_error_reason(&error).text, "1 is wrong; expected 2");
    (void)lx_fail(&error, "so: %s", error.what);
    assert_string_equal(lx_error_line(&error).text, "so: 1 is wrong");
    (void)lx_about(&error, LX_ABOUT_ITSELF, "", NULL);
    (void)lx_about(&error, LX_ABOUT_KEY, "nvm", "x");
    assert_string_equal(lx_error_line(&error).text, "so: 1 is wrong");
}

static void an_error_is_one_line_without_colours(void **state)
{
    struct lx_error error;
    (void)state;
    (void)lx_refuse(&error, "a\nb", "%s", "\033[31mred\r");
    (void)lx_about(&error, LX_ABOUT_SETTING, "k\a", "\x7F\t");
    assert_string_equal(lx_error_line(&error).text, "k?=??: ?[31mred?; a?b");
}

/* What is too long loses its end, and nothing else. */
static void long_errors_are_cut(void **state)
{
    struct lx_error error;
    char text[3000];
    (void)state;
    memset(text, 'x', sizeof text - 1);
    text[sizeof text - 1] = '\0';
    (void)lx_refuse(&error, "right", "%s", text);
    (void)lx_about(&error, LX_ABOUT_SETTING, text, text);
    (void)lx_stands(&error, text, 9);
    const struct lx_words line = lx_error_line(&error);
    assert_non_null(strstr(line.text, "x:9: x"));
    assert_true(strlen(line.text) < sizeof line.text);
}

/* The very name goes before one where '-' stands for '_'. */
static void encoders_by_name(void **state)
{
    static const char *const names[] = {"a-b", "A_b", "c-d", "c_e"};
    struct dg_plan plan;
    (void)state;
    plan_rig_begin(&plan, "w", dg_plan_find_kind("can", 3), "vcan0");
    for (int i = 0; i < 4; i++) {
        assert_int_equal(dg_plan_add_encoder(&plan, names[i], dg_device_find("f3668"), 0, 0), i);
    }
    assert_int_equal(dg_plan_find_encoder(&plan, "A-B"), 0);
    assert_int_equal(dg_plan_find_encoder(&plan, "a_b"), 1);
    assert_int_equal(dg_plan_find_encoder(&plan, "C_D"), 2);
    assert_int_equal(dg_plan_find_encoder(&plan, "c-e"), 3);
    assert_int_equal(dg_plan_find_encoder(&plan, "c-"), -1);
    assert_int_equal(dg_plan_find_encoder(&plan, "c-ee"), -1);
    lx_plan_free(&plan);
}

static void wires_of_plan_and_port_are_the_same(void **state)
{
    const struct dg_plan_wire_kind *modbus = dg_plan_find_kind("modbus:x", 6);
    (void)state;
    assert_non_null(modbus);
    assert_true(dg_plan_wire_has(modbus, "cycle"));
    assert_true(dg_plan_wire_has(modbus, "break_at"));
    assert_false(dg_plan_wire_has(modbus, "temperature"));
    assert_false(dg_plan_wire_has(dg_plan_find_kind("pty", 3), "cycle"));
    assert_null(dg_plan_find_kind("pt", 2));
    assert_null(dg_plan_find_kind("ptyx", 4));
    assert_int_equal(lx_wire_count, dg_plan_wire_count);
    for (size_t i = 0; i < dg_plan_wire_count; i++) {
        const struct dg_plan_wire_kind *kind = &dg_plan_wires[i];
        const struct lx_wire *door = &lx_wires[i];
        assert_ptr_equal(dg_plan_find_kind(kind->name, strlen(kind->name)), kind);
        assert_true(kind->stations_max > 0);
        assert_true(kind->where != NULL || !kind->where_needed);
        assert_int_equal(kind->keys == NULL, kind->settings == NULL);
        assert_string_equal(door->name, kind->name);
        assert_ptr_equal(lx_wire_of(kind), door);
        assert_non_null(door->make);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rows_are_whole),
        cmocka_unit_test(names_are_unique),
        cmocka_unit_test(limits_of_every_row),
        cmocka_unit_test(values_reach_their_place),
        cmocka_unit_test(what_is_out_of_range_is_refused),
        cmocka_unit_test(one_of_several_words),
        cmocka_unit_test(help_leaves_out_what_is_not_there),
        cmocka_unit_test(serial_numbers_get_zeros_in_front),
        cmocka_unit_test(figures_have_to_fit_each_other),
        cmocka_unit_test(settings_of_an_interbus_encoder),
        cmocka_unit_test(a_mistyped_key_names_those_of_the_encoder),
        cmocka_unit_test(a_key_of_another_wire_names_those_that_have_it),
        cmocka_unit_test(whoever_is_nearest_says_where),
        cmocka_unit_test(an_error_is_one_line_without_colours),
        cmocka_unit_test(long_errors_are_cut),
        cmocka_unit_test(encoders_by_name),
        cmocka_unit_test(wires_of_plan_and_port_are_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
