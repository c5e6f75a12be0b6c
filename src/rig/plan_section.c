/* SPDX-License-Identifier: MIT */
/*
 * A row for each kind of section. What a section refers to stands above it, so that each can be
 * checked when it ends, with all that it may clash with.
 */
#include "drehgeber/figure.h"
#include "drehgeber/key.h"
#include "drehgeber/shaft.h"
#include "rig_private.h"

#define RIGHT_ROOM 64u

/* ---------------------------------------------------------------- words */

struct dg_plan_setting *dg_plan_word_at(const struct rig_section *self, size_t index)
{
    return self->words - 1u - index;
}

const struct dg_plan_setting *dg_plan_word(const struct rig_section *self, const char *key)
{
    for (size_t i = 0; i < self->count; i++) {
        if (dg_plan_same(dg_plan_word_at(self, i)->key, key)) {
            return dg_plan_word_at(self, i);
        }
    }
    return NULL;
}

int dg_plan_word_add(struct rig_reader *in, struct rig_section *self,
                     const struct dg_plan_setting *word)
{
    struct dg_plan *plan = in->plan;
    const char *key = dg_plan_copy(plan, word->key);
    const char *value = key == NULL ? NULL : dg_plan_copy(plan, word->value);

    if (value == NULL || (size_t)(plan->end - plan->at) < sizeof *word) {
        plan->out = true;
        return -1;
    }
    plan->end -= sizeof *word;
    *dg_plan_word_at(self, self->count++) = (struct dg_plan_setting){key, value, word->line};
    return 0;
}

bool dg_plan_kind_has(const struct rig_kind *kind, const char *key)
{
    for (size_t i = 0; kind->keys[i].name != NULL; i++) {
        if (dg_plan_same(kind->keys[i].name, key)) {
            return true;
        }
    }
    return kind->numbered && dg_plan_is_address_key(key);
}

/* "expected a, b or c" */
static int refuse_section_key(struct rig_reader *in, const struct rig_section *self,
                              const struct dg_plan_setting *word)
{
    const struct rig_key *keys = self->kind->keys;
    struct rig_list list;
    size_t count = 0;

    while (keys[count].name != NULL) {
        count++;
    }
    dg_plan_list_begin(&list);
    for (size_t i = 0; i < count; i++) {
        dg_plan_list_item(&list, keys[i].name, i, count);
    }
    return dg_plan_wrong_word(in, word, RIG_SAY("expected ", list.room),
                              RIG_SAY("no key of [", self->kind->name, "]"));
}

static int check_words(struct rig_reader *in, const struct rig_section *self)
{
    for (size_t i = 0; i < self->count; i++) {
        const struct dg_plan_setting *word = dg_plan_word_at(self, i);
        const bool known = dg_plan_kind_has(self->kind, word->key);
        if (!known && !self->kind->open) {
            return refuse_section_key(in, self, word);
        }
        if (known && word->value[0] == '\0') {
            return dg_plan_wrong_word(in, word, RIG_SAY("expected ", word->key, " = VALUE"),
                                      RIG_SAY("empty"));
        }
    }
    return 0;
}

static bool is_wanted(const struct rig_section *self, const struct dg_plan_setting *word,
                      const struct dg_plan_wire_kind *wire, bool of_wire)
{
    return !dg_plan_kind_has(self->kind, word->key) && dg_plan_wire_has(wire, word->key) == of_wire;
}

int dg_plan_take_settings(struct rig_reader *in, const struct rig_section *self,
                          const struct dg_plan_wire_kind *wire, bool of_wire,
                          struct dg_plan_settings *to)
{
    size_t count = 0;
    size_t n = 0;

    for (size_t i = 0; i < self->count; i++) {
        count += is_wanted(self, dg_plan_word_at(self, i), wire, of_wire) ? 1u : 0u;
    }
    if (!dg_plan_make_settings(in->plan, to, count)) {
        return -1;
    }
    for (size_t i = 0; i < self->count; i++) {
        if (is_wanted(self, dg_plan_word_at(self, i), wire, of_wire)) {
            to->list[n++] = *dg_plan_word_at(self, i);
        }
    }
    return 0;
}

/* ---------------------------------------------------------------- what is wrong */

struct rig_line dg_plan_line_text(const struct dg_plan *plan, dg_plan_line line, dg_plan_line here)
{
    const struct dg_plan_place place = dg_plan_place(plan, line);
    const struct dg_plan_place other = dg_plan_place(plan, here);
    struct rig_line found = {.text = ""};
    struct dg_text text = dg_text_in(found.text, sizeof found.text);

    dg_text_add_number(&text, place.line);
    if (place.file != other.file) {
        dg_text_add(&text, " of ");
        dg_text_add(&text, place.file);
    }
    return found;
}

int dg_plan_stand(const struct dg_plan *plan, dg_plan_line line, struct dg_plan_error *error)
{
    const struct dg_plan_place place = dg_plan_place(plan, line);

    if (error->line == 0) {
        error->file = plan->file;
        error->line = place.line;
        if (place.file != plan->file) {
            struct dg_text text = dg_text_in(error->included, sizeof error->included);
            dg_plan_say_files(plan, line, &text);
        }
    }
    return -1;
}

int dg_plan_refuse_key(struct rig_reader *in, const char *key, dg_plan_line line)
{
    (void)dg_plan_about(in->error, key, NULL);
    return dg_plan_stand(in->plan, line, in->error);
}

int dg_plan_wrong_word(struct rig_reader *in, const struct dg_plan_setting *word, rig_parts right,
                       rig_parts what)
{
    (void)dg_plan_refuse(in->error, right, what);
    return dg_plan_refuse_key(in, word->key, word->line);
}

int dg_plan_wrong_section(struct rig_reader *in, const struct rig_section *section, rig_parts right,
                          rig_parts what)
{
    char name[2u * DG_PLAN_NAME_MAX];
    struct dg_text text = dg_text_in(name, sizeof name);

    dg_plan_add(&text, RIG_SAY("[", section->kind->name, " ", section->name, "]"));
    (void)dg_plan_refuse(in->error, right, what);
    return dg_plan_refuse_key(in, name, section->line);
}

int dg_plan_wrong_line(struct rig_reader *in, dg_plan_line line, rig_parts right, rig_parts what)
{
    (void)dg_plan_refuse(in->error, right, what);
    return dg_plan_stand(in->plan, line, in->error);
}

int dg_plan_taken(struct rig_reader *in, const struct rig_section *section, dg_plan_line by)
{
    return dg_plan_wrong_section(in, section, RIG_SAY("expected another name"),
                                 RIG_SAY("line ",
                                         dg_plan_line_text(in->plan, by, section->line).text,
                                         " has the name already"));
}

const char *dg_plan_path(struct rig_reader *in, const char *path, dg_plan_line line)
{
    const struct dg_plan_place place = dg_plan_place(in->plan, line);
    const size_t folder = path[0] == '/' ? 0 : place.folder;
    char *found = dg_plan_keep(in->plan, place.file, folder);

    if (found == NULL) {
        return NULL;
    }
    in->plan->at--; /* the rest begins where this one's zero is */
    return dg_plan_copy(in->plan, path) == NULL ? NULL : found;
}

bool dg_plan_name_fits(const char *name)
{
    size_t n = 0;

    while ((name[n] >= '0' && name[n] <= '9') || name[n] == '_' || name[n] == '-' ||
           (dg_text_upper(name[n]) >= 'A' && dg_text_upper(name[n]) <= 'Z')) {
        n++;
    }
    return n > 0 && n <= DG_PLAN_NAME_MAX && name[n] == '\0';
}

/* ---------------------------------------------------------------- [rig] */

/* A path of a socket or a token is the rig file's neighbour. */
static int add_control(struct rig_reader *in, const struct dg_plan_setting *word,
                       const struct dg_access_words *access)
{
    struct dg_plan_control *to = &in->plan->controls[in->plan->control_count];
    const size_t n = access->tcp ? 0 : dg_plan_length("unix:");
    const char *where = dg_plan_keep(in->plan, word->value, access->where);

    *to = (struct dg_plan_control){.tcp = access->tcp, .open = access->open, .line = word->line};
    if (where != NULL && n > 0) {
        const char *path = where + n;
        where = dg_plan_keep(in->plan, "unix:", n);
        in->plan->at -= where == NULL ? 0 : 1;
        where = where == NULL || dg_plan_path(in, path, word->line) == NULL ? NULL : where;
    }
    to->where = where;
    to->token_file = access->token == NULL ? NULL : dg_plan_path(in, access->token, word->line);
    in->plan->control_count++;
    return in->plan->out ? -1 : 0;
}

static int take_control(struct rig_reader *in, const struct dg_plan_setting *word)
{
    struct dg_access_words access;

    if (in->plan->control_count == DG_PLAN_CONTROLS_MAX) {
        return dg_plan_wrong_word(
            in, word, RIG_SAY("expected fewer"),
            RIG_SAY("one more than ", dg_plan_number(DG_PLAN_CONTROLS_MAX).text));
    }
    if (dg_access_read(word->value, &access, in->error) != 0) {
        return dg_plan_refuse_key(in, word->key, word->line);
    }
    return add_control(in, word, &access);
}

static int take_name(struct rig_reader *in, const struct dg_plan_setting *name)
{
    struct dg_plan *plan = in->plan;

    if (name == NULL) {
        return 0;
    }
    if (!dg_plan_name_fits(name->value)) {
        return dg_plan_wrong_word(in, name,
                                  RIG_SAY("expected 1 to ", dg_plan_number(DG_PLAN_NAME_MAX).text,
                                          " letters, digits, _ and -"),
                                  RIG_SAY(name->value, " is not a valid name"));
    }
    if (plan->name != NULL) {
        return dg_plan_wrong_word(in, name, RIG_SAY("expected one name"),
                                  RIG_SAY("the rig is called ", plan->name, " already"));
    }
    plan->name = name->value;
    return 0;
}

/* Those of the first [rig] that names some. */
static int take_threads(struct rig_reader *in, const struct dg_plan_setting *threads)
{
    static const struct dg_key row = {"threads",           "",   0, DG_KEY_U32, 0, 1, 1,
                                      DG_PLAN_THREADS_MAX, NULL, ""};
    uint32_t count = 0;
    char right[RIGHT_ROOM];
    struct dg_text text = dg_text_in(right, sizeof right);

    if (threads == NULL) {
        return 0;
    }
    if (dg_key_set(&row, &count, threads->value) != DG_OK) {
        dg_key_say_right(&row, &text);
        return dg_plan_wrong_word(in, threads, RIG_SAY(right),
                                  RIG_SAY(threads->value, " is not a valid number"));
    }
    in->plan->threads = in->plan->threads == 0 ? count : in->plan->threads;
    return 0;
}

/* The first file that says it is believed, as with the folder. */
static int take_course_memory(struct rig_reader *in, const struct dg_plan_setting *memory)
{
    uint64_t bytes = 0;

    if (memory == NULL || in->plan->course_memory != 0) {
        return 0;
    }
    if (!dg_unsigned_parse(memory->value, &bytes) || bytes < DG_PLAN_POINT_BYTES ||
        bytes > DG_PLAN_COURSE_MEMORY_MAX) {
        return dg_plan_wrong_word(in, memory, RIG_SAY("expected a number in 16..1099511627776"),
                                  RIG_SAY(memory->value, " is not a valid number"));
    }
    in->plan->course_memory = bytes;
    return 0;
}

static int take_rig(struct rig_reader *in, const struct rig_section *self)
{
    const struct dg_plan_setting *files = dg_plan_word(self, "files");
    int result = take_name(in, dg_plan_word(self, "name"));

    result = result == 0 ? take_threads(in, dg_plan_word(self, "threads")) : result;
    result = result == 0 ? take_course_memory(in, dg_plan_word(self, "memory")) : result;
    if (result == 0 && files != NULL && in->plan->files == NULL) {
        in->plan->files_line = files->line;
        in->plan->files = dg_plan_path(in, files->value, files->line);
        result = in->plan->files == NULL ? -1 : 0;
    }
    for (size_t i = 0; result == 0 && i < self->count; i++) {
        if (dg_plan_same(dg_plan_word_at(self, i)->key, "control")) {
            result = take_control(in, dg_plan_word_at(self, i));
        }
    }
    return result;
}

/* ---------------------------------------------------------------- the kinds */

_Static_assert(DG_PLAN_CONTROLS_MAX == 4u, "as the help of the rows has it");
_Static_assert(DG_PLAN_THREADS_MAX == 64u, "likewise");
_Static_assert(DG_PLAN_POINT_BYTES == 16u, "likewise");
_Static_assert(DG_PLAN_COURSE_MEMORY_MAX == 1099511627776u, "likewise");
_Static_assert(DG_PLAN_DEPTH_MAX == 8u, "likewise");
_Static_assert(DG_PLAN_INCLUDED_MAX == 1u << 20, "likewise");
_Static_assert(DG_SHAFT_GEARS_MAX == 8u, "likewise");

static const struct rig_key rig_keys[] = {
    {
        .name = "name",
        .takes = "NAME",
        .usual = "the file's name without its ending",
        .help = "name of the rig, and of its default control socket",
    },
    {
        .name = "control",
        .takes = "unix:PATH or tcp:HOST:PORT, with or without ,open and ,token=FILE",
        .usual = "a socket of the user, called NAME.sock",
        .help = "where clients control the rig; up to four times",
    },
    {
        .name = "files",
        .takes = "DIR",
        .usual = "the working directory, and nothing for clients over TCP",
        .help = "the folder for files that clients name; --files has priority",
    },
    {
        .name = "threads",
        .takes = "1..64",
        .usual = "1",
        .help = "that step packed buses of a simulation beside each other; how many there are "
                "changes nothing of what the rig does",
    },
    {
        .name = "memory",
        .takes = "16..1099511627776 bytes",
        .usual = "as much as there is",
        .help =
            "for the points of courses that clients ask for, 16 bytes each; a course beyond it is "
            "-225 to the client",
    },
    {
        .name = "include",
        .takes = "FILE",
        .usual = "none",
        .help =
            "include the sections of this file here, as often as you like; the file is in the "
            "folder of this file or below it, and not a link; at most 8 files deep, 4096 files and "
            "1 MiB in all",
    },
    {.name = NULL},
};
static const struct rig_key model_keys[] = {
    {
        .name = "base",
        .takes = "MODEL",
        .help = "a built-in model, or a [model] above; this model is a copy of it with other "
                "figures",
    },
    {
        .name = "inherit",
        .takes = "registers",
        .usual = "only frame and timing of the base",
        .help = "what else this model copies from the base",
    },
    {
        .name = "title",
        .takes = "TEXT",
        .usual = "as of the base",
        .help = "the text that drehgeber list prints",
    },
    {
        .name = "source",
        .takes = "TEXT",
        .usual = "none",
        .help = "the documents that were read, for readers of the file",
    },
    {
        .name = "unmodelled",
        .takes = "TEXT",
        .usual = "none",
        .help = "what the real encoder has and this model does not, for readers of the file",
    },
    {.name = NULL},
};
static const struct rig_key shaft_keys[] = {
    {
        .name = "motion",
        .takes = "MOTION or FILE.csv",
        .usual = "at rest at 0",
        .help = "how the shaft moves, as for --shaft",
    },
    {
        .name = "driver",
        .takes = "NAME",
        .usual = "none",
        .help =
            "the shaft above that turns this one, through at most 8 gears in a row; use it instead "
            "of motion",
    },
    {
        .name = "ratio",
        .takes = "TURNS:TURNS",
        .usual = "1:1",
        .help = "turns of this shaft for turns of the driver: whole numbers except 0, each may be "
                "negative, up to 2147483647",
    },
    {.name = NULL},
};
static const struct rig_key bus_keys[] = {
    {
        .name = "wire",
        .takes = "KIND",
        .help = "the kind of wire",
    },
    {
        .name = "address",
        .takes = "as --KIND",
        .usual = "the default of its kind",
        .help = "the address of the wire",
    },
    {
        .name = "trace",
        .takes = "FILE",
        .usual = "none",
        .help = "record the wire in this file, as for --trace",
    },
    {.name = NULL},
};
static const struct rig_key encoder_keys[] = {
    {
        .name = "model",
        .takes = "MODEL or FILE.eds",
        .help =
            "a model of drehgeber list, a [model] above, or an EDS or DCF file in the folder of "
            "this file or below it",
    },
    {
        .name = "shaft",
        .takes = "NAME",
        .usual = "the first shaft; in a file without shafts all encoders share one at rest",
        .help = "the shaft above that turns the encoder",
    },
    {
        .name = "bus",
        .takes = "NAME",
        .usual = "its own wire",
        .help = "the bus above that the encoder is on",
    },
    {
        .name = "wire",
        .takes = "KIND or KIND:ADDRESS",
        .usual = "a bus",
        .help = "the encoder's own wire; keys of the wire may be in this section, too",
    },
    {
        .name = "trace",
        .takes = "FILE",
        .usual = "none",
        .help = "record the encoder's own wire in this file",
    },
    {
        .name = "nvm",
        .takes = "FILE",
        .usual = "the EEPROM is lost at the end",
        .help = "keep the EEPROM in this file, which is created if it does not exist",
    },
    {
        .name = "serial",
        .takes = "N",
        .usual = "the model's",
        .help = "its serial number",
    },
    {.name = NULL},
};

/* clang-format off */
static const struct rig_kind kinds[] = {
    /* name      named  open   numb.  repeats    at once    keys          take */
    {"rig",      false, false, false, "control", "include", rig_keys,     take_rig},
    {"model",    true,  true,  false, NULL,      NULL,      model_keys,   dg_plan_take_model},
    {"shaft",    true,  false, false, NULL,      NULL,      shaft_keys,   dg_plan_take_shaft},
    {"bus",      true,  true,  false, NULL,      NULL,      bus_keys,     dg_plan_take_bus},
    {"encoder",  true,  true,  true,  NULL,      NULL,      encoder_keys, dg_plan_take_encoders},
};
/* clang-format on */

const struct rig_kind *dg_plan_kind_find(const char *name)
{
    for (size_t i = 0; i < DG_COUNT(kinds); i++) {
        if (dg_plan_same(kinds[i].name, name)) {
            return &kinds[i];
        }
    }
    return NULL;
}

int dg_plan_section_take(struct rig_reader *in, const struct rig_section *self)
{
    return check_words(in, self) != 0 ? -1 : self->kind->take(in, self);
}
