/* SPDX-License-Identifier: MIT */
/*
 * Results in words.
 */
#include "host_private.h"

/* The first ones pass through from the core. */
_Static_assert(DG_HOST_ERR_ARGUMENT == (int)DG_ERR_ARGUMENT, "one number, one meaning");
_Static_assert(DG_HOST_ERR_IO == (int)DG_ERR_IO, "one number, one meaning");
_Static_assert(DG_HOST_ERR_SPACE == (int)DG_ERR_SPACE, "one number, one meaning");
_Static_assert(DG_HOST_ERR_DAMAGED == (int)DG_ERR_DAMAGED, "one number, one meaning");
_Static_assert(DG_HOST_ERR_BLANK == (int)DG_ERR_BLANK, "one number, one meaning");
_Static_assert(DG_HOST_ERR_FOREIGN == (int)DG_ERR_FOREIGN, "one number, one meaning");
_Static_assert(DG_HOST_ERR_OLDER == (int)DG_ERR_OLDER, "one number, one meaning");

const char *dg_host_result_text(int result)
{
    static const char *const texts[] = {
        [-DG_HOST_OK] = "done",
        [-DG_HOST_ERR_ARGUMENT] = "out of its range",
        [-DG_HOST_ERR_IO] = "the EEPROM does not acknowledge",
        [-DG_HOST_ERR_SPACE] = "does not fit",
        [-DG_HOST_ERR_DAMAGED] = "the check sum is wrong",
        [-DG_HOST_ERR_BLANK] = "the EEPROM is empty",
        [-DG_HOST_ERR_FOREIGN] = "the EEPROM is another device's",
        [-DG_HOST_ERR_OLDER] = "of an earlier release",
        [-DG_HOST_ERR_NAME] = "no such name",
        [-DG_HOST_ERR_STATE] = "not now: too late to set, no power, or in the middle of a frame",
        [-DG_HOST_ERR_WIRE] = "not on the wire of this encoder",
        [-DG_HOST_ERR_LOST] = "events were lost: nobody fetched them in time",
        [-DG_HOST_ERR_OTHER] = "the state is of another model, version or build",
        [-DG_HOST_ERR_REFUSED] = "the encoder refuses",
        [-DG_HOST_ERR_SILENT] = "the encoder does not answer",
    };
    const int count = (int)DG_COUNT(texts);

    return result <= 0 && result > -count ? texts[-result] : "unknown result";
}
