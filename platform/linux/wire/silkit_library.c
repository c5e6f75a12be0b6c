/* SPDX-License-Identifier: MIT */
#include "silkit_library.h"

#include <dlfcn.h>
#include <stdlib.h>
#include <string.h>

#include "drehgeber/api.h"

#define VARIABLE "DREHGEBER_SILKIT_LIBRARY"
#define USUAL "libSilKit.so"
#define RIGHT                                                                                      \
    "a libSilKit.so of SIL Kit 5, named by " VARIABLE " or where the dynamic linker looks, is right"

/* A row: which function, and where its address goes. */
static const struct {
    const char *name;
    size_t at;
} functions[] = {
#define ROW(member, name, arguments) {"SilKit_" name, offsetof(struct lx_silkit_library, member)},
    LX_SK_FUNCTIONS(ROW)
#undef ROW
        {"SilKit_GetLastErrorString", offsetof(struct lx_silkit_library, last_error)},
};

_Static_assert(sizeof(void *) == sizeof(void (*)(void)), "POSIX: a function's address is one");

int lx_silkit_load(struct lx_silkit_library *self, struct lx_error *error)
{
    const char *given = getenv(VARIABLE);
    const char *file = given == NULL || given[0] == '\0' ? USUAL : given;
    void *library = dlopen(file, RTLD_NOW | RTLD_LOCAL);
    if (library == NULL) {
        const char *why = dlerror();
        return lx_refuse(error, RIGHT, "no SIL Kit library: %s", why == NULL ? file : why);
    }
    for (size_t i = 0; i < DG_COUNT(functions); i++) {
        const void *found = dlsym(library, functions[i].name);
        if (found == NULL) {
            (void)lx_refuse(error, RIGHT, "%s has no %s", file, functions[i].name);
            (void)dlclose(library);
            return -1;
        }
        memcpy((char *)self + functions[i].at, &found, sizeof found);
    }
    return 0;
}
