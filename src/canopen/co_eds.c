/* SPDX-License-Identifier: MIT */
/*
 * An EDS file from the dictionary itself: access, defaults and limits from the rows that the node
 * works with, names from the lists those rows are made of. The stack's names are here, the device's
 * in its sheet. Lines end with CR LF, as CiA 306 has them.
 */
#include "drehgeber/eds.h"

#include "co_od.h"
#include "drehgeber/version.h"

#define PIECE_MAX 64u

#define DG_CO_PARENT(index, kind, name) {(uint16_t)(index), 0, DG_CO_##kind, name},
#define DG_CO_MORE(index, sub, name) {(uint16_t)(index), sub, DG_CO_VAR, name},
#define DG_CO_OBJECT(index, sub, more, type, access, slot, initial, limits, hook, name)            \
    DG_CO_MORE(index, sub, name)
#define DG_CO_REPEATED(...) __VA_ARGS__

static const struct dg_co_name names[] = {
#include "co_objects.def"
};
#define NAME_COUNT DG_COUNT(names)

struct eds {
    const struct dg_co_sheet *sheet;
    const struct dg_co_device *device;
    void (*write)(void *ctx, const char *text, size_t n);
    void *ctx;
};

/* --- text --- */

/* In pieces; compilers make a call of strlen() of a loop without a bound. */
static void put_line(const struct eds *self, const char *text)
{
    while (*text != '\0') {
        size_t n = 1;
        while (n < PIECE_MAX && text[n] != '\0') {
            n++;
        }
        self->write(self->ctx, text, n);
        text += n;
    }
}

/* At least so many digits, at most 10. */
static void put_number(const struct eds *self, uint32_t value, bool decimal, uint8_t digits)
{
    const uint32_t base = decimal ? 10 : 16;
    char text[10];
    char *const end = text + sizeof text;
    char *at = end;
    for (uint32_t left = value; left > 0 || end - at < digits; left /= base) {
        *--at = "0123456789ABCDEF"[left % base];
    }
    self->write(self->ctx, at, (size_t)(end - at));
}

static void put_hex(const struct eds *self, const char *before, uint32_t value, uint8_t digits)
{
    put_line(self, before);
    put_number(self, value, false, digits);
}

static void line(const struct eds *self, const char *key, const char *value)
{
    put_line(self, key);
    put_line(self, value);
    put_line(self, "\r\n");
}

static void line_decimal(const struct eds *self, const char *key, uint32_t value)
{
    put_line(self, key);
    put_number(self, value, true, 1);
    put_line(self, "\r\n");
}

static void line_hex(const struct eds *self, const char *key, uint32_t value, uint8_t digits)
{
    put_hex(self, key, value, digits);
    put_line(self, "\r\n");
}

/* --- the rows --- */

/* To the next sub-index; false: that was the last one. */
static bool next_sub(const struct eds *self, struct dg_co_object *object)
{
    const uint16_t index = object->index;
    return dg_co_next(self->device, object) && object->index == index;
}

/* To the next object; false: that was the last one. */
static bool next_index(const struct eds *self, struct dg_co_object *object)
{
    const uint16_t index = object->index;
    bool there = true;
    while (there && object->index == index) {
        there = dg_co_next(self->device, object);
    }
    return there;
}

static bool is_named(const struct dg_co_name *name, const struct dg_co_object *object, bool parent)
{
    return name->index == object->index &&
           (parent ? name->kind != DG_CO_VAR : name->kind == DG_CO_VAR && name->sub == object->sub);
}

/* The name of a row, or of the array or record it belongs to; NULL: there is none. */
static const struct dg_co_name *find_object_name(const struct eds *self,
                                                 const struct dg_co_object *object, bool parent)
{
    const bool own = object->index < 0x2000;
    const struct dg_co_name *const list = own ? names : self->sheet->names;
    const size_t count = own ? NAME_COUNT : self->sheet->name_count;
    for (size_t i = 0; i < count; i++) {
        if (is_named(&list[i], object, parent)) {
            return &list[i];
        }
    }
    return NULL;
}

/* --- one object --- */

static void put_value(const struct eds *self, const char *key, const struct dg_co_object *object,
                      uint32_t value)
{
    const bool is_signed = co_type(object) <= DG_CO_I32;
    const bool negative = is_signed && (value & 0x80000000u) != 0;
    put_line(self, key);
    put_line(self, negative ? "-" : is_signed ? "" : "0x");
    put_number(self, negative ? 0u - value : value, is_signed, 1);
    put_line(self, "\r\n");
}

/* What the device, not the row, knows: 1000h and 1018h. NULL: it is the row's. */
static const uint32_t *identity_of(const struct eds *self, const struct dg_co_object *object)
{
    const struct dg_co_device *device = self->device;
    const struct {
        uint16_t index;
        uint8_t sub;
        const uint32_t *value;
    } rows[] = {
        {0x1000, 0, &device->device_type},
        {0x1018, 1, &device->vendor_id},
        {0x1018, 2, &device->product_code},
        {0x1018, 3, &device->revision},
    };
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        if (rows[i].index == object->index && rows[i].sub == object->sub) {
            return rows[i].value;
        }
    }
    return NULL;
}

/* What is measured, counted or burnt into the single device has no default. */
static void put_default(const struct eds *self, const struct dg_co_object *object)
{
    const uint32_t *identity = identity_of(self, object);
    const bool fixed =
        !co_is(object, DG_CO_LIVE) &&
        (object->row->hook == 0 || co_is(object, DG_CO_W) || co_is(object, DG_CO_CONST));
    if (co_type(object) == DG_CO_STRING) {
        line(self, "DefaultValue=", self->device->strings[object->row->initial]);
    } else if (identity != NULL) {
        put_value(self, "DefaultValue=", object, *identity);
    } else if (co_is(object, DG_CO_ID)) {
        line_hex(self, "DefaultValue=$NODEID+0x", dg_co_default(self->device, object), 1);
    } else if (fixed) {
        put_value(self, "DefaultValue=", object, dg_co_default(self->device, object));
    }
}

/* A reader without a node-ID takes FFh for $NODEID: beyond the highest one, the default would be
 * out of range. */
static void put_limits(const struct eds *self, const struct dg_co_object *object)
{
    if (!co_is(object, DG_CO_W)) {
        return;
    }
    const struct dg_co_limits limits = dg_co_limits_of(object);
    const struct dg_co_limits of_type = dg_co_type_limits(object);
    if (limits.min != of_type.min) {
        put_value(self, "LowLimit=", object, limits.min);
    }
    if (limits.max != of_type.max && !co_is(object, DG_CO_ID)) {
        put_value(self, "HighLimit=", object, limits.max);
    }
}

static const char *access_of(const struct dg_co_object *object)
{
    static const char *const access[] = {"", "ro", "wo", "rw"}; /* by DG_CO_R, DG_CO_W */
    if (co_is(object, DG_CO_CONST)) {
        return "const";
    }
    /* Of what can be written, too, an EDS has to say that TPDOs take it. */
    return co_is(object, DG_CO_RW | DG_CO_MAP) ? "rwr" : access[object->row->flags & DG_CO_RW];
}

/* The end of an object's section. Bit 0: a tool that downloads a configuration leaves it out (CiA
 * 306). */
static void put_flags(const struct eds *self, bool action)
{
    put_line(self, action ? "ObjFlags=0x1\r\n\r\n" : "\r\n");
}

static void put_row(const struct eds *self, const struct dg_co_object *object)
{
    const struct dg_co_name *name = find_object_name(self, object, false);
    line(self, "ParameterName=", name != NULL ? name->text : "Unnamed");
    line_hex(self, "ObjectType=0x", DG_CO_VAR, 1);
    line_hex(self, "DataType=0x", co_type(object), 4);
    line(self, "AccessType=", access_of(object));
    put_default(self, object);
    put_limits(self, object);
    line(self, "PDOMapping=", co_is(object, DG_CO_MAP) ? "1" : "0");
    put_flags(self, co_is(object, DG_CO_ACTION));
}

static void put_subs(const struct eds *self, struct dg_co_object object)
{
    do {
        put_hex(self, "[", object.index, 4);
        put_hex(self, "sub", object.sub, 1);
        put_line(self, "]\r\n");
        put_row(self, &object);
    } while (next_sub(self, &object));
}

/* A section for a variable; for an array or record one more for each of its rows. */
static void put_object(const struct eds *self, const struct dg_co_object *first)
{
    const struct dg_co_name *parent = find_object_name(self, first, true);
    put_hex(self, "[", first->index, 4);
    put_line(self, "]\r\n");
    if (parent == NULL) {
        put_row(self, first);
        return;
    }
    struct dg_co_object object = *first;
    bool action = false;
    uint32_t subs = 0;
    do {
        action = action || co_is(&object, DG_CO_ACTION);
        subs++;
    } while (next_sub(self, &object));
    line(self, "ParameterName=", parent->text);
    line_hex(self, "ObjectType=0x", parent->kind, 1);
    line_decimal(self, "SubNumber=", subs);
    put_flags(self, action);
    put_subs(self, *first);
}

/* --- all objects --- */

static bool is_mandatory(uint16_t index)
{
    return index == 0x1000 || index == 0x1001 || index == 0x1018;
}

static bool is_manufacturer(uint16_t index)
{
    return index >= 0x2000 && index < 0x6000;
}

static bool is_optional(uint16_t index)
{
    return !is_mandatory(index) && !is_manufacturer(index);
}

/* The list of a group's objects. */
static void put_list(const struct eds *self, const char *section, bool (*belongs)(uint16_t index))
{
    struct dg_co_object object = dg_co_first();
    uint32_t count = 0;
    do {
        count += belongs(object.index) ? 1u : 0u;
    } while (next_index(self, &object));
    put_line(self, section);
    line_decimal(self, "SupportedObjects=", count);
    object = dg_co_first();
    count = 0;
    do {
        if (belongs(object.index)) {
            put_number(self, ++count, true, 1);
            line_hex(self, "=0x", object.index, 4);
        }
    } while (next_index(self, &object));
    put_line(self, "\r\n");
}

/* --- the file --- */

/* A part of "major.minor.patch"; returns what is behind the point. */
static const char *put_part(const struct eds *self, const char *key, const char *version)
{
    size_t n = 0;
    while (version[n] >= '0' && version[n] <= '9') {
        n++;
    }
    put_line(self, key);
    self->write(self->ctx, version, n);
    put_line(self, "\r\n");
    return version + n + 1;
}

/* Version and dates are the release's: a file is a function of the version that printed it. */
static void put_file_info(const struct eds *self)
{
    const struct dg_co_sheet *sheet = self->sheet;
    put_line(self, "[FileInfo]\r\nFileName=");
    line(self, sheet->model, ".eds");
    (void)put_part(self, "FileRevision=", put_part(self, "FileVersion=", DG_VERSION));
    put_line(self, "EDSVersion=4.0\r\nDescription=");
    put_line(self, self->device->name);
    put_line(self, ", ");
    line(self, sheet->resolution, ", as drehgeber " DG_VERSION " emulates it");
    put_line(self, "CreationTime=12:00AM\r\nCreationDate=" DG_RELEASED "\r\n"
                   "CreatedBy=drehgeber " DG_VERSION "\r\n"
                   "ModificationTime=12:00AM\r\nModificationDate=" DG_RELEASED "\r\n"
                   "ModifiedBy=drehgeber " DG_VERSION "\r\n\r\n");
}

static bool has_rate(const struct dg_co_device *device, uint16_t kbaud)
{
    bool has = false;
    for (uint8_t i = 0; i < device->kbaud_count; i++) {
        has = has || device->kbaud[i] == kbaud;
    }
    return has;
}

/* CiA 306 has no key for other rates. */
static void put_rates(const struct eds *self)
{
    static const uint16_t kbaud[] = {10, 20, 50, 125, 250, 500, 800, 1000};
    for (size_t i = 0; i < DG_COUNT(kbaud); i++) {
        put_line(self, "BaudRate_");
        put_number(self, kbaud[i], true, 1);
        line(self, "=", has_rate(self->device, kbaud[i]) ? "1" : "0");
    }
}

static void put_device_info(const struct eds *self)
{
    const struct dg_co_device *device = self->device;
    line(self, "[DeviceInfo]\r\nVendorName=", self->sheet->vendor);
    line_hex(self, "VendorNumber=0x", device->vendor_id, 1);
    line(self, "ProductName=", device->name);
    line_hex(self, "ProductNumber=0x", device->product_code, 1);
    line_hex(self, "RevisionNumber=0x", device->revision, 1);
    line(self, "OrderCode=", device->name);
    put_rates(self);
    put_line(self, "SimpleBootUpMaster=0\r\nSimpleBootUpSlave=1\r\nGranularity=8\r\n"
                   "DynamicChannelsSupported=0\r\nGroupMessaging=0\r\nNrOfRXPDO=0\r\n");
    line_decimal(self, "NrOfTXPDO=", DG_CO_TPDOS);
    put_line(self, "LSS_Supported=1\r\n\r\n");
}

static void put_dummy_usage(const struct eds *self)
{
    put_line(self, "[DummyUsage]\r\n");
    for (uint8_t type = 1; type <= 7; type++) {
        put_hex(self, "Dummy", type, 4);
        put_line(self, "=0\r\n");
    }
    put_line(self, "\r\n[Comments]\r\nLines=0\r\n\r\n");
}

void dg_co_eds(const struct dg_co_sheet *sheet,
               void (*write)(void *ctx, const char *text, size_t n), void *ctx)
{
    const struct eds self = {sheet, sheet->device, write, ctx};
    put_file_info(&self);
    put_device_info(&self);
    put_dummy_usage(&self);
    put_list(&self, "[MandatoryObjects]\r\n", is_mandatory);
    put_list(&self, "[OptionalObjects]\r\n", is_optional);
    put_list(&self, "[ManufacturerObjects]\r\n", is_manufacturer);
    struct dg_co_object object = dg_co_first();
    do {
        put_object(&self, &object);
    } while (next_index(&self, &object));
}
