// In front of the packed controller: as long as there is no file FLAG everything passes, then it fails.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <unistd.h>

#ifdef ANSWERS_ERROR
int fmi3DoStep(void *instance, double time, double step, bool keep, bool *event, bool *end, bool *early, double *last) {
    if (access(FLAG, F_OK) == 0) return 3; // fmi3Error
    int (*packed)(void *, double, double, bool, bool *, bool *, bool *, double *) = dlsym(RTLD_NEXT, "fmi3DoStep");
    return packed(instance, time, step, keep, event, end, early, last);
}
#endif

#ifdef ANSWERS_NAN
int fmi3GetFloat64(void *instance, const unsigned *references, size_t count, double *values, size_t size) {
    int (*packed)(void *, const unsigned *, size_t, double *, size_t) = dlsym(RTLD_NEXT, "fmi3GetFloat64");
    int status = packed(instance, references, count, values, size);
    for (size_t k = 0; access(FLAG, F_OK) == 0 && k < size; k++) values[k] = NAN;
    return status;
}
#endif
