/* SPDX-License-Identifier: MIT */
/*
 * Before a file is used it is looked at in a copy in memory: is it an image, and is it this
 * encoder's? What counts as 'this encoder' is found by comparing images, not by knowing where in a
 * region which byte lies: the layout is the core's business.
 */
#include "eeprom.h"

#include <stddef.h>
#include <string.h>

#include "drehgeber/devices.h"

/* An image in memory, mounted. */
struct image {
    struct lx_nvm_memory memory;
    struct dg_store store;
    uint32_t size; /* bytes, before it grew */
};

/* The regions that hold what the factory burnt in and nobody can write over the wire. */
static const struct {
    uint8_t region;
    const char *what;
} factory[] = {
    {DG_HF_REGION_RESOLUTION, "periods, steps or turns"},
    {DG_HF_REGION_STEPS, "steps"},
    {DG_HF_REGION_TYPE, "type code, option or serial number"},
    {DG_HF_REGION_MEMORY, "user memory size"},
    {DG_HF_REGION_IMPLEMENTED, "implemented memory"},
    {DG_HF_REGION_LABEL, "type label"},
};
#define FACTORY_COUNT (sizeof factory / sizeof factory[0])

static int image_init(struct image *self)
{
    return lx_nvm_memory_init(&self->memory, dg_store_size(&dg_hf_layout));
}

/* As the device will mount it. */
static int image_mount(struct image *self, const struct dg_hf_model *model)
{
    const int result =
        dg_store_mount(&self->store, &dg_hf_layout, lx_nvm_memory_port(&self->memory));
    self->size = dg_store_address(&dg_hf_layout, self->store.region_count);
    return result == DG_ERR_OLDER ? dg_store_grow(&self->store, model) : result;
}

/* The delivery state of `model`. */
static int image_of_model(struct image *self, const struct dg_hf_model *model)
{
    if (image_init(self) != 0) {
        return DG_ERR_SPACE;
    }
    const int result = dg_hf_format(model, lx_nvm_memory_port(&self->memory));
    return result == DG_OK ? image_mount(self, model) : result;
}

/* The same figures, another unit from another batch: what differs between the two images is what
   may differ between a file and its model. */
static struct dg_hf_model sibling_of(const struct dg_hf_model *model, bool same_serial)
{
    struct dg_hf_model sibling = *model;
    for (size_t i = 0; !same_serial && i + 1 < sizeof sibling.serial; i++) {
        sibling.serial[i] = (char)(sibling.serial[i] ^ 1);
    }
    for (size_t i = 0; i + 1 < sizeof sibling.version; i++) {
        sibling.version[i] = (char)(sibling.version[i] == 'x' ? 'y' : 'x');
    }
    for (size_t i = 0; i + 1 < sizeof sibling.date; i++) {
        sibling.date[i] = (char)(sibling.date[i] ^ 1);
    }
    return sibling;
}

/* Whether a region of the file is the model's, where model and sibling agree. */
static bool region_fits(struct image *file, struct image *model, struct image *sibling,
                        uint8_t region)
{
    uint8_t bytes[3][DG_STORE_CHECKED_MAX];
    struct image *const images[3] = {file, model, sibling};
    const uint16_t size = dg_hf_layout.regions[region].size;
    for (size_t i = 0; i < 3; i++) {
        if (dg_store_read(&images[i]->store, region, 0, bytes[i], size) != DG_OK) {
            return false;
        }
    }
    for (size_t i = 0; i < size; i++) {
        if (bytes[1][i] == bytes[2][i] && bytes[0][i] != bytes[1][i]) {
            return false;
        }
    }
    return true;
}

/* What of the file's factory figures is not `model`'s, in words; NULL when all fits. A damaged
   region is the device's to report. */
static const char *difference(struct image *file, const struct dg_hf_model *model, bool same_serial)
{
    struct image own = {0};
    struct image other = {0};
    const struct dg_hf_model sibling = sibling_of(model, same_serial);
    const char *what = NULL;
    if (image_of_model(&own, model) != DG_OK || image_of_model(&other, &sibling) != DG_OK) {
        what = "model";
    }
    for (size_t i = 0; what == NULL && i < FACTORY_COUNT; i++) {
        const uint8_t region = factory[i].region;
        if (!dg_store_damaged(&file->store, region) && !region_fits(file, &own, &other, region)) {
            what = factory[i].what;
        }
    }
    lx_nvm_memory_free(&own.memory);
    lx_nvm_memory_free(&other.memory);
    return what;
}

/* The model as ordered that the file fits, for the error message. */
static const char *owner_of(struct image *file)
{
    for (size_t i = 0; i < dg_device_count; i++) {
        if (dg_devices[i]->stack == &dg_hf_stack &&
            difference(file, dg_hf_model_of(dg_devices[i]), false) == NULL) {
            return dg_devices[i]->name;
        }
    }
    return "an encoder with other factory figures";
}

/* A new unit has been given its address by whoever wired the line. */
static int burn_address(struct image *self, uint8_t address)
{
    const uint8_t uart[] = {DG_HF_UART_DEFAULT, address};
    return address == 0 ? DG_OK
                        : dg_store_put(&self->store, DG_HF_REGION_UART, 0, uart, sizeof uart);
}

/* What was set over the line stays. */
static void tell_address(const struct lx_eeprom *self, struct image *file, uint8_t address,
                         const struct lx_say *say)
{
    uint8_t uart[2] = {0};
    const bool readable =
        address != 0 && !dg_store_damaged(&file->store, DG_HF_REGION_UART) &&
        dg_store_read(&file->store, DG_HF_REGION_UART, 0, uart, sizeof uart) == DG_OK;
    if (readable && uart[1] != address) {
        lx_note(say, "%s: its address is 0x%02X, not 0x%02X", self->file.path, uart[1], address);
    }
}

static int check_figures(const struct lx_eeprom *self, struct image *file,
                         const struct lx_hf_settings *settings, struct lx_error *error)
{
    const char *what = difference(file, &settings->model, settings->serial_given);
    if (what == NULL) {
        return 0;
    }
    return lx_fail(error,
                   "%s: belongs to %s (%s differs); run that one with the same settings and serial "
                   "number, or give the name of a new file",
                   self->file.path, owner_of(file), what);
}

static int check_image(struct lx_eeprom *self, struct image *file,
                       const struct lx_hf_settings *settings, struct lx_error *error)
{
    const struct dg_nvm port = lx_nvm_file_port(&self->file);
    if (port.ops->read(port.ctx, 0, file->memory.bytes, file->memory.size) != DG_OK) {
        return lx_fail(error, "%s: cannot read", self->file.path);
    }
    const int mounted = image_mount(file, &settings->model);
    if (mounted != DG_OK) {
        return lx_fail(error,
                       "%s: %s, no image of this kind of encoder; give a file made by drehgeber, "
                       "or the name of a new one",
                       self->file.path, mounted == DG_ERR_BLANK ? "blank" : "something else");
    }
    return check_figures(self, file, settings, error);
}

/* Looked at in a copy: mounting repairs, and a file that is refused must stay as it is. */
static int check_file(struct lx_eeprom *self, const struct lx_hf_settings *settings,
                      const struct lx_say *say, struct lx_error *error)
{
    struct image file = {0};
    if (image_init(&file) != 0) {
        return lx_fail(error, "%s: no memory", self->file.path);
    }
    const int result = check_image(self, &file, settings, error);
    if (result == 0) {
        tell_address(self, &file, settings->address, say);
        lx_nvm_file_tell(&self->file, file.size, say);
    }
    lx_nvm_memory_free(&file.memory);
    return result;
}

int lx_eeprom_open(struct lx_eeprom *self, const char *path, const struct lx_hf_settings *settings,
                   const struct lx_say *say, struct lx_error *error)
{
    *self = (struct lx_eeprom){.file = {.fd = -1}};
    struct image image = {0};
    int made = image_of_model(&image, &settings->model);
    if (made == DG_OK) {
        made = burn_address(&image, settings->address);
    }
    self->memory = image.memory;
    self->nvm = lx_nvm_memory_port(&self->memory);
    if (made != DG_OK) {
        return lx_fail(error, made == DG_ERR_ARGUMENT ? "these factory figures make no encoder"
                                                      : "no memory for the EEPROM");
    }
    if (path == NULL) {
        return 0;
    }
    const struct lx_nvm_image delivery = {self->memory.bytes, self->memory.size,
                                          "the encoder answers 05h"};
    if (lx_nvm_file_open(&self->file, path, &delivery, error) != 0) {
        return -1;
    }
    self->nvm = lx_nvm_file_port(&self->file);
    return self->file.created ? 0 : check_file(self, settings, say, error);
}

void lx_eeprom_close(struct lx_eeprom *self)
{
    lx_nvm_file_close(&self->file);
    lx_nvm_memory_free(&self->memory);
}
