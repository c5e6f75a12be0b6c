# SPDX-License-Identifier: MIT
"""Models as C: what `drehgeber model --c` writes is compiled, and compared with the models as they were read."""
import json
import os
import re
import subprocess
from pathlib import Path

import pytest

from rig import REPOSITORY, run, run_refused

LIBRARY = Path(os.environ.get("LIBDREHGEBER", REPOSITORY / "build/release/libdrehgeber.so"))
# All figures that a text can change, and a frame of those that have one.
OWN = """[model own]
base = s3684-biss
mt = 8
st = 12
lc = 1
frame = 0 P W L E C
error = high
warning = high
crc_poly = 25h
crc_start = 1Fh
crc = plain
busy_us = 1.5
title = it's "own" \\\\ ??/
source = none */ at all
[model word]
base = ssi-28
frame = F 1 E T P Y
parity = odd
parity_over = position
error_parity = 1
once = 1
monoflop_us = 33
[model label]
base = s3684-rs485
version = v9
date = 01.02.03
temperature_min = -7
commands = 42h,50h,52h
vector_min = 500
[model ring]
base = ocd-ib-k3
loop = 1
steps_minus_one = 1
id_code = 33h
[model ids]
base = s3684-biss
inherit = registers
device_id = 010203040506
manufacturer = 524Ch
profile_id = 43h
"""
MAIN = r"""
#include <stdio.h>
#include <string.h>
#include "drehgeber/drehgeber.h"
#include "drehgeber/host_wire.h"
#include "drehgeber/rig.h"

extern const struct dg_device %(names)s;
static const struct dg_device *const made[] = {%(addresses)s};
static _Alignas(16) unsigned char memory[2][65536];

/* What lies behind the pointers of a form; how much there is of it. */
static const void *form_of(const struct dg_device *device, size_t *n)
{
    if (device->stack == &dg_biss_stack && dg_biss_model_of(device)->form != NULL) {
        *n = sizeof(struct dg_biss_form) - offsetof(struct dg_biss_form, crc_poly);
        return &dg_biss_model_of(device)->form->crc_poly;
    }
    if (device->stack == &dg_ssi_stack && dg_ssi_model_of(device)->form != NULL) {
        *n = sizeof(struct dg_ssi_form) - offsetof(struct dg_ssi_form, layout);
        return dg_ssi_model_of(device)->form->layout;
    }
    *n = 0;
    return NULL;
}

static size_t figures(const struct dg_device *device, unsigned char *to)
{
    if (device->stack == &dg_biss_stack) {
        struct dg_biss_model model;
        memcpy(&model, device->model, sizeof model);
        model.form = NULL;
        model.layout = NULL; /* of the EEPROM: C has none of its own */
        memcpy(to, &model, sizeof model);
        return sizeof model;
    }
    if (device->stack == &dg_ssi_stack) {
        struct dg_ssi_model model;
        memcpy(&model, device->model, sizeof model);
        model.form = NULL;
        memcpy(to, &model, sizeof model);
        return sizeof model;
    }
    const bool hf = device->stack == &dg_hf_stack;
    const size_t n = hf ? sizeof(struct dg_hf_model) : sizeof(struct dg_ib_model);
    const size_t at = hf ? offsetof(struct dg_hf_model, layout) : offsetof(struct dg_ib_model, layout);
    memcpy(to, device->model, n);
    memset(to + at, 0, sizeof(void *));
    return n;
}

/* A frame at 5 turns and a quarter; 0: it has none. */
static uint64_t frame_of(const struct dg_device *device)
{
    static _Alignas(16) unsigned char room[65536];
    struct dg_host_frame frame = {.at = 0};
    struct dg_host *host = dg_host_init(room, sizeof room, device, dg_host_wire_of(device));
    if (host == NULL || dg_host_power(host, 0, true) != DG_HOST_OK) {
        return 1;
    }
    (void)dg_host_step(host, 1000000000u);
    dg_host_shaft(host, 1000000000u, INT64_C(21) << 30, 0);
    return dg_host_frame(host, 1000000000u, &frame) == DG_HOST_OK ? frame.bits : 0;
}

static const char *difference(const struct dg_device *read, const struct dg_device *c)
{
    size_t forms[2];
    const void *form[2] = {form_of(read, &forms[0]), form_of(c, &forms[1])};
    if (strcmp(read->wire, c->wire) != 0 || strcmp(read->resolution, c->resolution) != 0 || read->stack != c->stack) {
        return "device";
    }
    if (figures(read, memory[0]) != figures(c, memory[1]) ||
        memcmp(memory[0], memory[1], figures(read, memory[0])) != 0) {
        return "figures";
    }
    if (forms[0] != forms[1] || (forms[0] != 0 && memcmp(form[0], form[1], forms[0]) != 0)) {
        return "form";
    }
    return frame_of(read) == frame_of(c) ? "same" : "frame";
}

static void tell_figures(const struct dg_device *read)
{
    for (size_t i = 0; i < sizeof made / sizeof *made; i++) {
        if (strcmp(made[i]->name, read->name) == 0) {
            printf("%%s %%s\n", read->name, difference(read, made[i]));
        }
    }
}

int main(int argc, char **argv)
{
    static _Alignas(16) unsigned char plans[262144];
    static char text[65536];
    for (size_t i = 0; i < dg_device_count; i++) {
        tell_figures(dg_devices[i]);
    }
    for (int i = 1; i < argc; i++) {
        struct dg_plan plan;
        struct dg_plan_error error;
        FILE *file = fopen(argv[i], "rb");
        const size_t n = fread(text, 1, sizeof text, file);
        fclose(file);
        const struct dg_plan_setup setup = {.size = sizeof setup, .file = argv[i], .text = {text, n},
                                            .memory = plans, .memory_size = sizeof plans};
        if (dg_plan_read(&plan, &setup, &error) != DG_OK) {
            return 2;
        }
        for (size_t j = 0; j < plan.model_count; j++) {
            tell_figures(plan.models[j].device);
        }
    }
    return 0;
}
"""


def made(name, env):
    ended = run("model", name, "--c", env=env)
    assert (ended.returncode, ended.stderr) == (0, ""), ended.stderr
    return ended.stdout


@pytest.fixture(scope="module")
def models(tmp_path_factory):
    """All models that have figures, the environment that has them, and their files."""
    folder = tmp_path_factory.mktemp("models")
    (folder / "own.ini").write_text(OWN)
    env = {**os.environ, "DREHGEBER_MODELS": str(folder)}
    rows = [row for row in json.loads(run("list", "--json", env=env).stdout) if "can" not in row["wires"]]
    return rows, env, sorted({row["file"] for row in rows if "file" in row})


def compare(rows, texts, files, folder):
    """What a program says of them, which has the C of all."""
    symbols = [re.search(r"^const struct dg_device (\w+) = ", text, re.M).group(1) for text in texts]
    for row, text in zip(rows, texts):
        (folder / f"{row['model']}.c").write_text(text)
    (folder / "main.c").write_text(MAIN % {"names": ", ".join(symbols), "addresses": ", ".join(f"&{name}" for name in symbols)})
    sources = [folder / f"{row['model']}.c" for row in rows]
    strict = ["-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror", *os.environ.get("CFLAGS", "").split()]
    subprocess.run(["gcc", *strict, f"-I{REPOSITORY}/include", "-o", folder / "compare", folder / "main.c", *sources,
                    LIBRARY, f"-Wl,-rpath,{LIBRARY.parent}"], check=True)
    ended = subprocess.run([folder / "compare", *files], capture_output=True, text=True, check=True)
    return dict(line.split() for line in ended.stdout.splitlines())


def test_what_is_compiled_is_what_was_read(models, tmp_path):
    rows, env, files = models
    texts = [made(row["model"], env) for row in rows]
    assert {row["model"] for row in rows} > {"own", "word", "label", "ring", "s3684-biss", "rls-la11-24"}
    assert compare(rows, texts, files, tmp_path) == {row["model"]: "same" for row in rows}


def test_the_comparison_sees_what_differs(models, tmp_path):
    rows, env, files = models
    rows = [row for row in rows if row["model"] in ("own", "word", "label")]
    changes = {"own": (".crc_start = 31", ".crc_start = 30"), "word": (".monoflop = 33000", ".monoflop = 32000"),
               "label": ("RS485", "RS 485")}
    texts = [made(row["model"], env).replace(*changes[row["model"]]) for row in rows]
    assert compare(rows, texts, files, tmp_path) == {"own": "form", "word": "figures", "label": "device"}


def test_it_says_where_it_is_from(models):
    _, env, _ = models
    text = made("own", env)
    assert " * own, made by drehgeber " in text and " * Source: none * / at all\n" in text
    assert "Not modelled" not in text and "Not modelled: " in made("rls-la11-26", env)


def test_what_has_no_c():
    assert "f3658 has no figures that C can have" in run_refused(2, "model", "f3658", "--c")
    assert "model needs a model; valid: " in run_refused(2, "model", "--c")
    assert "model ssi-13 does nothing; expected 'drehgeber model MODEL --c'" in run_refused(2, "model", "ssi-13")
    assert "none.ini: cannot open" in run_refused(2, "model", "none.ini", "--c")
