/* SPDX-License-Identifier: MIT */
/* A real CANopen encoder (verify_canopen.c), its objects (verify_canopen_sdo.c), and how they are put back: what
   is in force (verify_canopen_back.c), and what is saved (verify_canopen_saved.c). */
#ifndef DREHGEBER_TOOL_VERIFY_CANOPEN_H
#define DREHGEBER_TOOL_VERIFY_CANOPEN_H

#include "canopen_steps.h"
#include "verify_frames.h"
#include "verify_parts.h"

/* Whom the rows talk to. */
#define ROW_NODE 0x3Fu
/* How long an SDO server may take; the manual has no limit. */
#define ANSWER_MAX DG_S(1)
/* What a host adds to a moment, beside its measured jitter. */
#define HOST_ADDS DG_MS(20)
/* How long something that must not come is waited for. */
#define SILENCE DG_MS(20)
#define READINGS 20u
#define MOVES_MAX 64u
/* Frames that are looked at for one of the node: a bus may be busy, and a babbling one is left. */
#define FRAMES_MAX 4000u
/* Frames that are kept for one that a row waits for later. */
#define PASSED_MAX 16u
/* Late answers that are dropped for one that is awaited. */
#define LATE_MAX 16u
/* Most objects that a row writes. */
#define TOUCHED_MAX 40u
#define TPDOS 4u
/* Most notes of what is saved. */
#define KEPT_MAX 120u
/* In place of an abort code: a value has more than four bytes. */
#define LONGER 1u
/* Objects that 1011h does not bring back. */
#define BUS_FIRST 0x2100u
#define BUS_LAST 0x2105u

#define SDO_REQUEST 0x600u
/* Of a COB-ID: nothing is sent with it. */
#define OFF 0x80000000u
#define SDO_ANSWER 0x580u
/* An identifier that no frame has. */
#define NOBODY 0xFFFFu
/* How long an answer to what was before may be on its way. */
#define SETTLE DG_MS(5)
#define GUARDING (0x700u + ROW_NODE)

/* What a note of the journal is about, as its identifier: the download that it has puts that back. */
enum note_of {
    NOTE_NOW, /* an object that the row writes, as it was in force */
    NOTE_CUT, /* the same of any other, which is written back only if a cut of the supply has changed one */
    NOTE_SAVED, /* an object as it was saved, to be saved again */
    NOTE_FIXED  /* the same of one that is not written back: it must still be so */
};

/* An object, and what it was. */
struct object {
    uint16_t index;
    uint8_t sub;
};

struct canopen {
    struct verify_encoder base;
    struct cf_canopen_trial trial;
    struct verify_frames wire;
    const struct dg_device *device;
    uint8_t node;
    bool alone;
    bool irreversible;
    dg_ns jitter;
    uint32_t moves;
    uint32_t position;                  /* of 6004h, before the row */
    struct object touched[TOUCHED_MAX]; /* what the row that was rehearsed last writes */
    size_t touched_count;
    bool stores;                       /* the same row needs what is saved, to be put back */
    bool one_way;                      /* and something that cannot be written back */
    struct verify_note kept[KEPT_MAX]; /* what is saved; 0 of them: not known yet */
    size_t kept_count;
    bool delivered;                     /* what is saved is what was delivered */
    char refusal[160];                  /* why a row that stores is not run; "": it is */
    struct object written[TOUCHED_MAX]; /* what the row has written, and the encoder confirmed */
    size_t written_count;
    bool loads;     /* 1011h has confirmed to bring back what was delivered, with the next reset */
    bool restored;  /* that was done */
    uint32_t abort; /* code of the upload that was refused last, or LONGER; 0: neither */
    struct object unread; /* that an encoder has, and that could not be noted; 0: none */
    struct dg_can_frame request;
    struct dg_can_frame passed[PASSED_MAX]; /* since the request, with other identifiers */
    size_t passed_count;
};

/* What an object or the data of an answer are. */
enum kind {
    CONSTANT,   /* it is what the model says */
    CONFIGURED, /* so it is as delivered, but somebody may have changed it */
    MEASURED,   /* any value is right */
    TEXT,       /* any characters are right */
    POSITION    /* near to the model's */
};

static inline struct canopen *of(struct verify_encoder *base)
{
    return (struct canopen *)base;
}

static inline uint32_t le32(const uint8_t *from)
{
    return (uint32_t)from[3] << 24 | (uint32_t)from[2] << 16 | (uint32_t)from[1] << 8 | from[0];
}

/* Send it; `report` says why not. */
bool verify_canopen_send_frame(struct canopen *self, const struct dg_can_frame *frame,
                               struct cf_report *report);

/* The next frame with this identifier since the last request, 0: that answers something. @return 1, 0: none
   came, -1: lost, as `report` says */
int verify_canopen_receive_id(struct canopen *self, uint16_t id, dg_ns until,
                              struct dg_can_frame *to, struct cf_report *report);

/* Upload an object of at most four bytes. @return how many, 0: it was not answered so; `abort` may say why */
size_t verify_canopen_upload(struct canopen *self, uint16_t index, uint8_t sub, uint32_t *value);

/* Send a whole request of a download. @return whether it was confirmed */
bool verify_canopen_download(struct canopen *self, const struct cf_unit *unit);

/* No transfer is left of the row before, no answer is on its way; and somebody is there. */
bool verify_canopen_settle(struct canopen *self, struct cf_report *report);

bool verify_canopen_is_near(const struct canopen *self, uint32_t a, uint32_t b);

enum kind verify_canopen_kind_of_object(uint16_t index);

/* Whether the object of this answer to an upload has a value that the row knows. */
bool verify_canopen_is_known(const struct canopen *self, const uint8_t *answer);

/* The encoder has answered: if that confirms a download, its object is known. */
void verify_canopen_remember(struct canopen *self, const struct cf_unit *answer);

/* The encoder starts anew, with what it has stored, or with what it was delivered with. */
void verify_canopen_forget(struct canopen *self);

/* --- what is in force --- */

/* Note what an object is; of one that is there and cannot be read, `unread` says so. @return false: the
   journal has no room */
bool verify_canopen_note_object(struct canopen *self, enum note_of of, uint16_t index, uint8_t sub);

/* Note a download that puts `value` of `n` bytes into an object. */
bool verify_canopen_note_download(struct canopen *self, enum note_of of,
                                  const struct object *object, uint32_t value, size_t n);

/* Note a TPDO and its mapping in the order in which they can be written. */
bool verify_canopen_note_tpdo(struct canopen *self, enum note_of of, unsigned number);

/* Note everything that the row will write, before it writes any of it. */
bool verify_canopen_note_touched(struct canopen *self, struct cf_report *report);

/* Send all downloads of such notes; what an encoder says to them is no matter. */
void verify_canopen_write_notes(struct canopen *self, enum note_of of);

/* The first note from `first` to `last` whose object is something else. @return journal->count: none */
size_t verify_canopen_find_changed(struct canopen *self, enum note_of first, enum note_of last);

/* See verify_parts.h. */
bool verify_canopen_put_back(struct verify_encoder *base, struct cf_report *report);

/* --- what is saved --- */

/* Whether a write to it can be put back only by way of what is saved: it saves, deletes that, or presets. */
bool verify_canopen_needs_saved(uint16_t index);

/* Before a row that cuts the supply or stores, note what is in force; before one that stores also everything that
   is saved. The first time, the supply is cut for that. `refusal` says why that cannot be. False: the encoder is
   lost, as `report` says. */
bool verify_canopen_note_saved(struct canopen *self, struct cf_report *report);

/* A row that stores begins with what was delivered, once all notes are on the disk. False: as `report` says */
bool verify_canopen_deliver(struct canopen *self, struct cf_report *report);

/* Whether the journal has what was saved. */
bool verify_canopen_has_saved(const struct canopen *self);

/* Save that again, and see it after the supply was cut. False: as `report` says. */
bool verify_canopen_save_again(struct canopen *self, struct cf_report *report);

#endif
