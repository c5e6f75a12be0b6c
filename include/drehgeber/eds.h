/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The EDS file (CiA 306) of a CANopen device, from the dictionary that the node works with: access,
 * defaults and limits from its rows, names from a list that only this is for. Who does not call it
 * does not carry it: it is in objects of its own, and no device points to a sheet.
 */
#ifndef DREHGEBER_EDS_H
#define DREHGEBER_EDS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/canopen.h"
#include "drehgeber/text.h"

#ifdef __cplusplus
extern "C" {
#endif

/** ObjectType of CiA 306. */
enum dg_co_kind {
    DG_CO_VAR = 0x7, /**< of a row */
    DG_CO_ARRAY = 0x8,
    DG_CO_RECORD = 0x9,
};

/** Name of a row, or of the array or record that the rows of an index belong to. */
struct dg_co_name {
    uint16_t index;
    uint8_t sub;  /**< of a row */
    uint8_t kind; /**< enum dg_co_kind */
    const char *text;
};

/** What an EDS file says of a device beside its dictionary. */
struct dg_co_sheet {
    const struct dg_co_device *device;
    const char *model;              /**< the file's name, without ".eds" */
    const char *resolution;         /**< in words */
    const char *vendor;             /**< name of the manufacturer */
    const struct dg_co_name *names; /**< of the device's rows */
    uint16_t name_count;
};

/**
 * Write the EDS file through `write`, in pieces of any length that are not terminated. It is the
 * same for every run of a version. `write` may do what it likes but change the sheet.
 */
DG_API void dg_co_eds(const struct dg_co_sheet *sheet,
                      void (*write)(void *ctx, const char *text, size_t n), void *ctx);

/* ---------------------------------------------------------------- reading */

/** Longest text of a file, its objects, and its sub-indices with those of compact arrays. */
#define DG_EDS_BYTES_MAX 1048576u
#define DG_EDS_OBJECTS_MAX 4000u
#define DG_EDS_ROWS_MAX 16384u

/** What is noted of a file, or wrong with it. Section, key and value are cut off where they are
 * longer. */
struct dg_eds_note {
    unsigned line;    /**< 0: none in particular */
    char section[32]; /**< "": none in particular; likewise the next two */
    char key[32];
    char value[48];
    const char *what;  /**< what is done with it, or wrong */
    const char *right; /**< what is expected; NULL: nothing else */
    bool lacks;        /**< the file promises what the node does not do; else it was tolerated */
};

/** Append where it stands in its section: "[6501] DefaultValue=No"; nothing if that is not said. */
DG_API void dg_co_say_place(const struct dg_eds_note *note, struct dg_text *to);

/** A file to be read. */
struct dg_eds_setup {
    size_t size;      /**< sizeof(struct dg_eds_setup) */
    const char *text; /**< of an EDS or DCF file (CiA 306), any bytes */
    size_t n;
    void *memory; /**< for what is made of it, as long as that is used; aligned for any type */
    size_t memory_size;
    /** What is tolerated, is a value only, or is left out. NULL: nobody wants to know. */
    void (*note)(void *ctx, const struct dg_eds_note *note);
    void *ctx;
};

/** A value that only stores: what a file has beyond the objects of the device it is put on. */
struct dg_co_cell {
    uint32_t key;     /**< DG_CO_KEY() */
    uint32_t initial; /**< default; signed ones sign-extended, likewise the limits */
    struct dg_co_limits limits;
    bool follows; /**< the node-ID is added to the default */
    uint8_t type; /**< enum dg_co_type */
};

/** Longest text, octet string and domain. */
#define DG_EDS_LONG_MAX 1024u

/** What the bytes of a dg_co_long are. */
enum dg_co_long_kind {
    DG_CO_LONG_BYTES,
    DG_CO_LONG_UNSIGNED,
    DG_CO_LONG_SIGNED,
};

/** A value that 32 bits do not hold: a text, a domain, a number of 24 or of 40 to 64 bits. */
struct dg_co_long {
    uint32_t key;   /**< DG_CO_KEY() */
    uint8_t kind;   /**< enum dg_co_long_kind */
    uint8_t access; /**< DG_CO_R, DG_CO_W */
    uint16_t least; /**< bytes that it has */
    uint16_t most;
    uint16_t n;             /**< bytes of the default */
    const uint8_t *initial; /**< default */
    uint64_t min;           /**< of a number; sign-extended where it is signed */
    uint64_t max;
    uint32_t at; /**< with DG_CO_W: its place in the memory of such values */
    bool kept;   /**< by 1010h */
    /** The base's object of 64 bits that it behaves as; .row NULL: it only stores. Its hook has two
     * words, the low one first. */
    struct dg_co_object bound;
};

/**
 * A device from a file. Its dictionary is whole; objects that `base` has, too, behave as there, and
 * its values that the file lacks are kept beside it. Cells lie behind the application's state.
 */
struct dg_co_file {
    struct dg_co_device device; /**< first: a hook finds the file by the device */
    const struct dg_co_device *base;
    uint16_t profile; /**< low 16 bits of 1000h for which the base's profile counts */
    struct dg_store_layout layout;
    const struct dg_co_cell *cells; /**< sorted by their keys */
    const struct dg_co_long *longs; /**< likewise */
    uint16_t cell_count;
    uint16_t long_count;
    uint16_t kept;       /**< so many of the cells are kept by 1010h */
    uint16_t longs_kept; /**< ... and of the others */
    uint16_t long_kept;  /**< bytes that these take */
    uint16_t objects;    /**< indices of the dictionary */
    uint16_t bound;      /**< sub-indices that behave */
    uint16_t plain;      /**< ... and values */
    uint8_t node_id;     /**< as the file says; 0: it does not */
    uint32_t serial;     /**< 1018h:4 of the file; 0: it does not say */
    size_t used;         /**< bytes of the memory, from its beginning; the rest is free again */
    size_t cells_at;     /**< bytes from dg_co_setup.application to the cells' values */
    size_t longs_at;     /**< ... and to those of `longs` */
    size_t more;         /**< bytes from `cells_at` on that a node needs */
    const char *vendor;  /**< "": the file does not say */
};

/** What a file is put on. */
struct dg_co_ground {
    /** The device whose objects, causes, store regions and functions it has; `vendor_id` and
     * `product_code` are those of the file. Its default bus parameters are those of the file. */
    const struct dg_co_device *(*choose)(uint32_t device_type, uint32_t vendor_id,
                                         uint32_t product_code);
    uint16_t profile; /**< low 16 bits of 1000h for which its objects from 6000h on count */
    size_t cells_at;  /**< bytes of the application's state */
};

/**
 * Read an EDS or DCF file.
 * @return 0; DG_ERR_SPACE: more memory is needed; DG_ERR_ARGUMENT with `error`, or not a setup of
 * this version
 */
DG_API int dg_co_read(struct dg_co_file *self, const struct dg_eds_setup *setup,
                      const struct dg_co_ground *ground, struct dg_eds_note *error);

/** What a sub-index does. */
enum dg_co_role {
    DG_CO_SIMULATED,
    DG_CO_STORES,   /**< any value within its limits */
    DG_CO_CONSTANT, /**< its default, for ever */
    DG_CO_ROLE_COUNT
};

/** What row `n` of the file's dictionary does. */
DG_API enum dg_co_role dg_co_role_of(const struct dg_co_file *self, uint16_t n);

/** Line of the first section of an object, e.g. [6501]; 0: there is none. */
DG_API unsigned dg_co_find_object(const struct dg_eds_setup *setup, uint16_t index);

/** Why an object of an image is not one of a file. */
enum dg_co_misfit {
    DG_CO_FOREIGN, /**< 1000h or 1018h: another device type, vendor, product or revision */
    DG_CO_GONE,    /**< the file has no such value */
    DG_CO_NEW,     /**< the image has none */
    DG_CO_RETYPED,
    DG_CO_OUTSIDE, /**< its value is outside of the file's limits */
    DG_CO_MISFIT_COUNT
};

/**
 * Copy what fits from the EEPROM of a device of any file to that of `self`, which was formatted and
 * never used. What does not fit is told with its DG_CO_KEY(). An image in which nothing was ever
 * saved does not say of which file it is.
 * @param from is repaired where a power cut left it; give a copy
 * @param to ops NULL: nothing is copied
 * @return 0; DG_ERR_FOREIGN: not one of a file that is put on the same encoder; DG_ERR_IO
 */
DG_API int dg_co_convert(const struct dg_co_file *self, struct dg_nvm from, struct dg_nvm to,
                         void (*tell)(void *ctx, uint32_t key, enum dg_co_misfit why), void *ctx);

/** The type of an object; DG_CO_TYPE_COUNT: it is not there. */
DG_API enum dg_co_type dg_co_type_at(const struct dg_co_device *device, uint32_t key);

/** The value of an object that stores, is constant, or is not there, which is 0; of a node with
 * such a device. */
DG_API uint32_t dg_co_value_of(const struct dg_co_node *node, uint32_t key);

/** The values of the cells of a node with such a device: as many as its file has cells. */
DG_API uint32_t *dg_co_cells(const struct dg_co_node *node);

#ifdef __cplusplus
}
#endif

#endif
