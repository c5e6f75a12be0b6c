/* SPDX-License-Identifier: MIT */
/*
 * A model as C: its figures as initialisers of the structs that they lie in, a line for each that
 * is not 0, and a device that has them.
 */
#define _GNU_SOURCE
#include "model_c.h"

#include <ctype.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "drehgeber/drehgeber.h"
#include "model_eds_c.h"
#include "run.h"

/* How a member is written down. */
enum kind { UNSIGNED, SIGNED, FLAG, TEXT, BYTES };

struct member {
    const char *name;
    size_t offset;
    size_t size;
    enum kind kind;
};

#define MEMBER(type, field, kind)                                                                  \
    {                                                                                              \
#field, offsetof(struct type, field), sizeof(((struct type *)NULL)->field), kind           \
    }

#define BISS(field, kind) MEMBER(dg_biss_model, field, kind)
static const struct member biss_members[] = {
    BISS(multiturn_bits, UNSIGNED), BISS(singleturn_bits, UNSIGNED),
    BISS(life_counter, FLAG),       BISS(autostore, FLAG),
    BISS(sl_low_at_start, FLAG),    BISS(stop_bit_early, FLAG),
    BISS(unidirectional, FLAG),     BISS(serial, UNSIGNED),
    BISS(device_id, BYTES),         BISS(busy, UNSIGNED),
    BISS(busy_jitter, UNSIGNED),    BISS(eeprom_read, UNSIGNED),
    BISS(eeprom_write, UNSIGNED),   BISS(init, UNSIGNED),
    BISS(timeout, UNSIGNED),        BISS(hint, UNSIGNED),
    BISS(profile_id, UNSIGNED),     BISS(no_eds, FLAG),
};
#define BISS_FORM(field, kind) MEMBER(dg_biss_form, field, kind)
static const struct member biss_form_members[] = {
    BISS_FORM(crc_poly, UNSIGNED), BISS_FORM(crc_start, UNSIGNED), BISS_FORM(crc_plain, FLAG),
    BISS_FORM(error_high, FLAG),   BISS_FORM(warning_high, FLAG),  BISS_FORM(around, UNSIGNED),
    BISS_FORM(layout, TEXT),
};

#define SSI(field, kind) MEMBER(dg_ssi_model, field, kind)
static const struct member ssi_members[] = {
    SSI(multiturn_bits, UNSIGNED), SSI(singleturn_bits, UNSIGNED),
    SSI(code, UNSIGNED),           SSI(error_bit, UNSIGNED),
    SSI(parity, UNSIGNED),         SSI(once, FLAG),
    SSI(monoflop, UNSIGNED),       SSI(init, UNSIGNED),
};
#define SSI_FORM(field, kind) MEMBER(dg_ssi_form, field, kind)
static const struct member ssi_form_members[] = {
    SSI_FORM(layout, TEXT),
    SSI_FORM(parity_over, UNSIGNED),
    SSI_FORM(error_parity, FLAG),
    SSI_FORM(around, UNSIGNED),
};

#define HF(field, kind) MEMBER(dg_hf_model, field, kind)
static const struct member hf_members[] = {
    HF(periods_per_turn, UNSIGNED),
    HF(steps_per_period, UNSIGNED),
    HF(turns, UNSIGNED),
    HF(type_code, UNSIGNED),
    HF(option_code, UNSIGNED),
    HF(memory_blocks, UNSIGNED),
    HF(implemented_blocks, UNSIGNED),
    HF(serial, TEXT),
    HF(version, TEXT),
    HF(date, TEXT),
    HF(designation, TEXT),
    HF(temperature_channel, UNSIGNED),
    HF(led_channel, UNSIGNED),
    HF(vector_channel, UNSIGNED),
    HF(temperature_min_degc, SIGNED),
    HF(temperature_max_degc, SIGNED),
    HF(led_min_ma, UNSIGNED),
    HF(led_max_ma, UNSIGNED),
    HF(vector_min, UNSIGNED),
    HF(vector_max, UNSIGNED),
    HF(speed_max_rpm, UNSIGNED),
    HF(acceleration_max_krad_s2, UNSIGNED),
    HF(reaction, UNSIGNED),
    HF(init, UNSIGNED),
    HF(lacks, UNSIGNED),
};

#define IB(field, kind) MEMBER(dg_ib_model, field, kind)
static const struct member ib_members[] = {
    IB(profile, UNSIGNED),      IB(loop, FLAG),
    IB(steps, UNSIGNED),        IB(turns, UNSIGNED),
    IB(steps_minus_one, FLAG),  IB(temperature_sensor, FLAG),
    IB(param_cycles, UNSIGNED), IB(serial, UNSIGNED),
    IB(version, UNSIGNED),      IB(self_test, UNSIGNED),
    IB(id_code, UNSIGNED),
};

/* A struct that a model has, or that its model points to. */
struct shape {
    const char *type;
    const struct member *members;
    size_t count;
    const char *functions; /* of a form: initialisers of what it calls, as they are written down */
};

static const struct {
    const struct dg_stack *stack;
    const char *name; /* of the stack */
    const char *header;
    struct shape model;
    struct shape form;
    size_t pointer; /* to the form, in the model */
} protocols[] = {
    {
        .stack = &dg_biss_stack,
        .name = "dg_biss_stack",
        .header = "biss.h",
        .model = {"dg_biss_model", biss_members, DG_COUNT(biss_members), NULL},
        .form = {"dg_biss_form", biss_form_members, DG_COUNT(biss_form_members),
                 "    .fits = dg_biss_layout_fits,\n"
                 "    .make_frame = dg_biss_layout_make_frame,\n"
                 "    .take_apart = dg_biss_layout_take_apart,\n"},
        .pointer = offsetof(struct dg_biss_model, form),
    },
    {
        .stack = &dg_ssi_stack,
        .name = "dg_ssi_stack",
        .header = "ssi.h",
        .model = {"dg_ssi_model", ssi_members, DG_COUNT(ssi_members), NULL},
        .form = {"dg_ssi_form", ssi_form_members, DG_COUNT(ssi_form_members),
                 "    .fits = dg_ssi_layout_fits,\n"
                 "    .find_position = dg_ssi_layout_find_position,\n"
                 "    .make_word = dg_ssi_layout_make_word,\n"
                 "    .take_apart = dg_ssi_layout_take_apart,\n"},
        .pointer = offsetof(struct dg_ssi_model, form),
    },
    {
        .stack = &dg_hf_stack,
        .name = "dg_hf_stack",
        .header = "hiperface.h",
        .model = {"dg_hf_model", hf_members, DG_COUNT(hf_members), NULL},
    },
    {
        .stack = &dg_ib_stack,
        .name = "dg_ib_stack",
        .header = "interbus.h",
        .model = {"dg_ib_model", ib_members, DG_COUNT(ib_members), NULL},
    },
};

/* --- members --- */

/* '?' might begin a trigraph; three digits end where they end. */
void model_put_text(const char *text)
{
    (void)putchar('"');
    for (; *text != '\0'; text++) {
        const unsigned char c = (unsigned char)*text;
        const bool plain = c >= ' ' && c < 0x7F;
        (void)printf(!plain ? "\\%03o" : strchr("\"\\?", c) != NULL ? "\\%c" : "%c", c);
    }
    (void)putchar('"');
}

static void put_bytes(const unsigned char *bytes, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        (void)printf("%s0x%02X", i == 0 ? "{" : ", ", (unsigned)bytes[i]);
    }
    (void)putchar('}');
}

/* A number of so many bytes, in the order of this machine. */
static uint64_t number_at(const void *at, size_t size)
{
    uint8_t one = 0;
    uint16_t two = 0;
    uint32_t four = 0;
    uint64_t eight = 0;
    switch (size) {
    case sizeof one:
        memcpy(&one, at, sizeof one);
        return one;
    case sizeof two:
        memcpy(&two, at, sizeof two);
        return two;
    case sizeof four:
        memcpy(&four, at, sizeof four);
        return four;
    default:
        memcpy(&eight, at, sizeof eight);
        return eight;
    }
}

static void put_value(const struct member *self, const void *at)
{
    int16_t number = 0;
    switch (self->kind) {
    case UNSIGNED:
        (void)printf("%" PRIu64, number_at(at, self->size));
        break;
    case SIGNED:
        memcpy(&number, at, sizeof number);
        (void)printf("%d", number);
        break;
    case FLAG:
        (void)fputs("true", stdout);
        break;
    case TEXT:
        model_put_text(at);
        break;
    case BYTES:
        put_bytes(at, self->size);
        break;
    }
}

static bool is_zero(const unsigned char *bytes, size_t n)
{
    return n == 0 || (bytes[0] == 0 && memcmp(bytes, bytes + 1, n - 1u) == 0);
}

static void put_members(const struct shape *shape, const void *from)
{
    for (size_t i = 0; i < shape->count; i++) {
        const struct member *member = &shape->members[i];
        const unsigned char *at = (const unsigned char *)from + member->offset;
        if (!is_zero(at, member->size)) {
            (void)printf("    .%s = ", member->name);
            put_value(member, at);
            (void)fputs(",\n", stdout);
        }
    }
}

/* --- the whole --- */

/* As names of variables may be. */
static struct lx_words symbol_of(const struct dg_device *device)
{
    struct lx_words symbol = {"model_"};
    for (const char *at = device->name; *at != '\0'; at++) {
        lx_words_add(&symbol, "%c", isalnum((unsigned char)*at) ? *at : '_');
    }
    return symbol;
}

/* In a comment, which a text must not end. */
static void put_note(const char *title, const char *text)
{
    if (text == NULL) {
        return;
    }
    (void)printf(" * %s: ", title);
    for (; *text != '\0'; text++) {
        (void)printf(text[0] == '*' && text[1] == '/' ? "* " : "%c", *text);
    }
    (void)putchar('\n');
}

static void put_file_head(const struct options *options, const char *header)
{
    const struct dg_plan_model *text = options->text;
    (void)printf("/*\n * %s, made by drehgeber %s.\n", options->device->name, dg_version());
    put_note("Source", text == NULL ? NULL : text->source);
    put_note("Not modelled", text == NULL ? NULL : text->unmodelled);
    (void)printf(" */\n#include \"drehgeber/%s\"\n#include \"drehgeber/devices.h\"\n", header);
}

/* Members that are initialisers already, in words. */
struct last {
    const char *stack;
    const char *model; /* behind its symbol */
    bool cells;        /* it takes memory of its own */
};

static void put_device(const struct dg_device *device, const char *symbol, const struct last *last)
{
    const struct {
        const char *name;
        const char *text;
    } texts[] = {
        {"name", device->name}, {"wire", device->wire}, {"resolution", device->resolution}};
    (void)printf("extern const struct dg_device %s;\nconst struct dg_device %s = {\n", symbol,
                 symbol);
    for (size_t i = 0; i < DG_COUNT(texts); i++) {
        (void)printf("    .%s = ", texts[i].name);
        model_put_text(texts[i].text);
        (void)fputs(",\n", stdout);
    }
    (void)printf("    .stack = &%s,\n    .model = &%s_%s,\n", last->stack, symbol, last->model);
    if (last->cells) {
        (void)printf("    .more = sizeof %s_cells / sizeof *%s_cells * sizeof(uint32_t),\n", symbol,
                     symbol);
    }
    (void)fputs("};\n", stdout);
}

static void put_model(const struct options *options, size_t protocol)
{
    const struct dg_device *device = options->device;
    const struct shape *model = &protocols[protocol].model;
    const struct shape *form = &protocols[protocol].form;
    const struct lx_words symbol = symbol_of(device);
    const struct last last = {.stack = protocols[protocol].name, .model = "figures"};
    const void *figures = NULL;
    if (form->type != NULL) {
        memcpy(&figures, (const char *)device->model + protocols[protocol].pointer, sizeof figures);
    }
    put_file_head(options, protocols[protocol].header);
    (void)putchar('\n');
    if (figures != NULL) {
        (void)printf("static const struct %s %s_form = {\n%s", form->type, symbol.text,
                     form->functions);
        put_members(form, figures);
        (void)fputs("};\n", stdout);
    }
    (void)printf("static const struct %s %s_figures = {\n", model->type, symbol.text);
    put_members(model, device->model);
    if (figures != NULL) {
        (void)printf("    .form = &%s_form,\n", symbol.text);
    }
    (void)fputs("};\n", stdout);
    put_device(device, symbol.text, &last);
}

static int put_eds(const struct options *options, const struct dg_cia406_file *file)
{
    const struct lx_words symbol = symbol_of(options->device);
    const struct last last = {
        .stack = "dg_cia406_stack", .model = "file.model", .cells = file->file.cell_count > 0};
    const int result = model_eds_check(file, options->model);
    if (result == EXIT_OK) {
        put_file_head(options, "cia406.h");
        (void)fputs("#include \"drehgeber/eds_rows.h\"\n\n", stdout);
        model_eds_put(file, symbol.text);
        put_device(options->device, symbol.text, &last);
    }
    return result;
}

int model_command(const struct options *options)
{
    const struct dg_device *device = options->device;
    struct lx_words right = {""};
    size_t i = 0;
    if (device == NULL) {
        lx_stack_models(NULL, &right);
        lx_complain("model needs a model; valid:%s, or MODELS.ini", right.text);
        return EXIT_USAGE;
    }
    if (!options->c) {
        lx_complain("model %s does nothing; expected 'drehgeber %s'", options->model,
                    options->row->usage);
        return EXIT_USAGE;
    }
    if (model_eds_of(device) != NULL) {
        return put_eds(options, model_eds_of(device));
    }
    while (i < DG_COUNT(protocols) && protocols[i].stack != device->stack) {
        i++;
    }
    if (i == DG_COUNT(protocols)) {
        lx_complain("%s has no figures that C can have; expected a model of another protocol",
                    device->name);
        return EXIT_USAGE;
    }
    put_model(options, i);
    return EXIT_OK;
}
