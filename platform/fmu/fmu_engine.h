/* SPDX-License-Identifier: MIT */
/* A rig of an FMU: for the sources of this folder only. fmu_rig.c reads it, fmu_engine.c runs it. */
#ifndef DREHGEBER_FMU_ENGINE_H
#define DREHGEBER_FMU_ENGINE_H

#include "bundle.h"
#include "drehgeber/rig_engine.h"
#include "encoder.h"

/** A model of the file that is neither built in nor of its texts. */
struct shelf_model {
    struct shelf_model *next;
    struct fmu_encoder of; /* its device only */
};

/** Points of a motion or a course. */
struct point_list {
    struct point_list *next;
    void *points; /* owned */
    struct dg_rig_course course;
};

/** A wire, and who tells the importer of it. */
struct rig_wire {
    struct fmu *all;
    size_t index;
    struct fmu_encoder *leader;
};

/** A rig. */
struct fmu_rig {
    struct fmu_bundle bundle;
    char *file; /* owned: what it is called in the bundle */
    struct dg_plan plan;
    void *plan_memory;          /* owned, likewise all below */
    struct shelf_model *models; /* while and after the plan is read */
    struct point_list *points;  /* of the engine at hand */
    struct rig_wire *wires;
    void *memory;
    struct dg_engine *engine;
    struct dg_plan_error *error; /* of whoever wants to know; NULL: nobody */
};

#endif
