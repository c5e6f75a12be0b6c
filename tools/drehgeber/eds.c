/* SPDX-License-Identifier: MIT */
/*
 * An EDS file from the dictionary itself: access, defaults and limits from the rows that the node
 * works with, names from the lists those rows are made of.
 */
#include "eds.h"

#include <inttypes.h>
#include <stdlib.h>

#include "../../src/canopen/co_od.h"
#include "drehgeber/drehgeber.h"

/* ObjectType of CiA 306. */
enum kind {
    VAR = 0x7,
    ARRAY = 0x8,
    RECORD = 0x9,
};

/* Name of a row, or of the array or record that rows belong to. */
struct name {
    uint16_t index;
    uint8_t sub;
    enum kind kind; /* VAR: of a row */
    const char *text;
};

#define DG_CO_PARENT(index, kind, name) {(uint16_t)(index), 0, kind, name},
#define DG_CO_OBJECT(index, sub, type, access, slot, region, initial, min, max, hook, name)        \
    {(uint16_t)(index), sub, VAR, name},

static const struct name names[] = {
#include "../../src/canopen/co_objects.def"
#include "../../src/cia406/objects.def"
};
#define NAME_COUNT (sizeof names / sizeof names[0])

/* How far a type reaches; signed limits are sign-extended. */
static const struct {
    uint32_t min;
    uint32_t max;
} ranges[] = {
    [DG_CO_I8] = {0xFFFFFF80u, 0x7F},
    [DG_CO_I16] = {0xFFFF8000u, 0x7FFF},
    [DG_CO_I32] = {0x80000000u, 0x7FFFFFFF},
    [DG_CO_U8] = {0, 0xFF},
    [DG_CO_U16] = {0, 0xFFFF},
    [DG_CO_U32] = {0, 0xFFFFFFFFu},
    [DG_CO_STRING] = {0, 0},
};

struct eds {
    const struct dg_co_device *device;
    FILE *to;
};

/* --- the rows --- */

static unsigned row_count(const struct eds *self)
{
    return (unsigned)co_object_count + self->device->object_count;
}

static const struct dg_co_object *row(const struct eds *self, unsigned i)
{
    return i < co_object_count ? &co_objects[i] : &self->device->objects[i - co_object_count];
}

static bool is_first(const struct eds *self, unsigned i)
{
    return i == 0 || row(self, i - 1)->index != row(self, i)->index;
}

static unsigned subs_of(const struct eds *self, unsigned first)
{
    unsigned i = first;
    while (i < row_count(self) && row(self, i)->index == row(self, first)->index) {
        i++;
    }
    return i - first;
}

static const char *name_of(const struct dg_co_object *object)
{
    for (size_t i = 0; i < NAME_COUNT; i++) {
        if (names[i].kind == VAR && names[i].index == object->index &&
            names[i].sub == object->sub) {
            return names[i].text;
        }
    }
    return "Unnamed";
}

/* The array or record that a row belongs to; NULL: it stands alone. */
static const struct name *parent_of(const struct dg_co_object *object)
{
    for (size_t i = 0; i < NAME_COUNT; i++) {
        if (names[i].kind != VAR && names[i].index == object->index) {
            return &names[i];
        }
    }
    return NULL;
}

/* --- one object --- */

static void print_value(const struct eds *self, const char *key, const struct dg_co_object *object,
                        uint32_t value)
{
    if (object->type <= DG_CO_I32) {
        (void)fprintf(self->to, "%s=%" PRId32 "\n", key, (int32_t)value);
    } else {
        (void)fprintf(self->to, "%s=0x%" PRIX32 "\n", key, value);
    }
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
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        if (rows[i].index == object->index && rows[i].sub == object->sub) {
            return rows[i].value;
        }
    }
    return NULL;
}

/* What is measured, counted or burnt into the single device has no default. */
static void print_default(const struct eds *self, const struct dg_co_object *object)
{
    const uint32_t *identity = identity_of(self, object);
    const bool fixed = (object->flags & DG_CO_LIVE) == 0 &&
                       (object->hook == NULL || (object->flags & (DG_CO_W | DG_CO_CONST)) != 0);
    if (object->type == DG_CO_STRING) {
        (void)fprintf(self->to, "DefaultValue=%s\n", self->device->strings[object->initial]);
    } else if (identity != NULL) {
        print_value(self, "DefaultValue", object, *identity);
    } else if ((object->flags & DG_CO_ID) != 0) {
        (void)fprintf(self->to, "DefaultValue=$NODEID+0x%" PRIX32 "\n", object->initial);
    } else if (fixed) {
        print_value(self, "DefaultValue", object, co_default(self->device, object));
    }
}

static void print_limits(const struct eds *self, const struct dg_co_object *object)
{
    if ((object->flags & DG_CO_W) == 0) {
        return;
    }
    if (object->min != ranges[object->type].min) {
        print_value(self, "LowLimit", object, object->min);
    }
    const uint32_t max = co_maximum(self->device, object);
    if (max != ranges[object->type].max) {
        print_value(self, "HighLimit", object, max);
    }
}

static const char *access_of(const struct dg_co_object *object)
{
    static const char *const access[] = {"", "ro", "wo", "rw"}; /* by DG_CO_R, DG_CO_W */
    if ((object->flags & DG_CO_CONST) != 0) {
        return "const";
    }
    /* Of what can be written, too, an EDS has to say that TPDOs take it. */
    const unsigned all = DG_CO_RW | DG_CO_MAP;
    return (object->flags & all) == all ? "rwr" : access[object->flags & DG_CO_RW];
}

/* Bit 0: a tool that downloads a configuration leaves it out (CiA 306). */
static void print_flags(const struct eds *self, bool action)
{
    if (action) {
        (void)fputs("ObjFlags=0x1\n", self->to);
    }
}

static void print_row(const struct eds *self, const struct dg_co_object *object)
{
    (void)fprintf(self->to, "ParameterName=%s\nObjectType=0x%X\nDataType=0x%04X\nAccessType=%s\n",
                  name_of(object), (unsigned)VAR, object->type, access_of(object));
    print_default(self, object);
    print_limits(self, object);
    (void)fprintf(self->to, "PDOMapping=%d\n", (object->flags & DG_CO_MAP) != 0);
    print_flags(self, (object->flags & DG_CO_ACTION) != 0);
    (void)fputs("\n", self->to);
}

/* A section for a variable; for an array or record one more for each of its rows. */
static void print_object(const struct eds *self, unsigned first)
{
    const struct dg_co_object *object = row(self, first);
    const struct name *parent = parent_of(object);
    const unsigned subs = subs_of(self, first);
    (void)fprintf(self->to, "[%04X]\n", object->index);
    if (parent == NULL) {
        print_row(self, object);
        return;
    }
    bool action = false;
    for (unsigned i = first; i < first + subs; i++) {
        action = action || (row(self, i)->flags & DG_CO_ACTION) != 0;
    }
    (void)fprintf(self->to, "ParameterName=%s\nObjectType=0x%X\nSubNumber=%u\n", parent->text,
                  (unsigned)parent->kind, subs);
    print_flags(self, action);
    (void)fputs("\n", self->to);
    for (unsigned i = first; i < first + subs; i++) {
        (void)fprintf(self->to, "[%04Xsub%X]\n", object->index, row(self, i)->sub);
        print_row(self, row(self, i));
    }
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
static void print_list(const struct eds *self, const char *section, bool (*belongs)(uint16_t index))
{
    unsigned count = 0;
    for (unsigned i = 0; i < row_count(self); i++) {
        count += is_first(self, i) && belongs(row(self, i)->index);
    }
    (void)fprintf(self->to, "[%s]\nSupportedObjects=%u\n", section, count);
    count = 0;
    for (unsigned i = 0; i < row_count(self); i++) {
        if (is_first(self, i) && belongs(row(self, i)->index)) {
            (void)fprintf(self->to, "%u=0x%04X\n", ++count, row(self, i)->index);
        }
    }
    (void)fputs("\n", self->to);
}

/* --- the file --- */

/* Version and dates are the release's: a file is a function of the version that printed it. */
static void print_file_info(const struct eds *self, const struct dg_device *model)
{
    char *end = NULL;
    const unsigned long version = strtoul(dg_version(), &end, 10);
    const unsigned long revision = strtoul(end + 1, NULL, 10);
    (void)fprintf(self->to,
                  "[FileInfo]\nFileName=%s.eds\nFileVersion=%lu\nFileRevision=%lu\n"
                  "EDSVersion=4.0\nDescription=%s, %s, as drehgeber %s emulates it\n"
                  "CreationTime=12:00AM\nCreationDate=" DREHGEBER_RELEASED "\n"
                  "CreatedBy=drehgeber %s\n"
                  "ModificationTime=12:00AM\nModificationDate=" DREHGEBER_RELEASED "\n"
                  "ModifiedBy=drehgeber %s\n\n",
                  model->name, version, revision, self->device->name, model->resolution,
                  dg_version(), dg_version(), dg_version());
}

/* 100 kBd, which the encoder has, too, has no key. */
static void print_device_info(const struct eds *self)
{
    const struct dg_co_device *device = self->device;
    (void)fprintf(self->to,
                  "[DeviceInfo]\nVendorName=Kuebler\nVendorNumber=0x%" PRIX32 "\n"
                  "ProductName=%s\nProductNumber=0x%" PRIX32 "\nRevisionNumber=0x%" PRIX32 "\n"
                  "OrderCode=%s\n",
                  device->vendor_id, device->name, device->product_code, device->revision,
                  device->name);
    (void)fprintf(self->to,
                  "BaudRate_10=1\nBaudRate_20=1\nBaudRate_50=1\nBaudRate_125=1\nBaudRate_250=1\n"
                  "BaudRate_500=1\nBaudRate_800=0\nBaudRate_1000=1\n"
                  "SimpleBootUpMaster=0\nSimpleBootUpSlave=1\nGranularity=8\n"
                  "DynamicChannelsSupported=0\nGroupMessaging=0\nNrOfRXPDO=0\nNrOfTXPDO=%u\n"
                  "LSS_Supported=1\n\n",
                  DG_CO_TPDOS);
}

static void print_dummy_usage(const struct eds *self)
{
    (void)fputs("[DummyUsage]\n", self->to);
    for (unsigned type = 1; type <= 7; type++) {
        (void)fprintf(self->to, "Dummy%04X=0\n", type);
    }
    (void)fputs("\n[Comments]\nLines=0\n\n", self->to);
}

void eds_print(const struct dg_device *device, FILE *to)
{
    const struct eds self = {.device = dg_cia406_model_of(device)->device, .to = to};
    print_file_info(&self, device);
    print_device_info(&self);
    print_dummy_usage(&self);
    print_list(&self, "MandatoryObjects", is_mandatory);
    print_list(&self, "OptionalObjects", is_optional);
    print_list(&self, "ManufacturerObjects", is_manufacturer);
    for (unsigned i = 0; i < row_count(&self); i++) {
        if (is_first(&self, i)) {
            print_object(&self, i);
        }
    }
}
