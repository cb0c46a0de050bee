/* An FMU of FMI 2.0 with twelve numbers and a whole one, and what a test wants it to do in its calls. As a plant it stands at (0, 0, 1); as a
   controller it pulls every cable alike. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "fmi2Functions.h"

#ifndef ON_LOAD
#define ON_LOAD
#endif
#ifndef ON_INSTANTIATE
#define ON_INSTANTIATE
#endif
#ifndef ON_STEP
#define ON_STEP
#endif
#ifndef ON_FREE
#define ON_FREE
#endif

static fmi2Real numbers[12] = {10, 10, 10, 10, 10, 10, 0, 0, 1, 0, 0, 0};
static fmi2Integer whole = 3;
static fmi2CallbackFunctions callbacks;

__attribute__((unused)) static void complain(const char *text) {
    callbacks.logger(callbacks.componentEnvironment, "foreign", fmi2Error, "test", text);
}

__attribute__((unused)) static void hang(void) {
    for (;;) pause();
}

__attribute__((unused)) static void leave(const char *path) {
    FILE *file = fopen(path, "w");
    fprintf(file, "%d", (int)getpid());
    fclose(file);
}

__attribute__((constructor)) static void load(void) { ON_LOAD; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *given, fmi2Boolean visible, fmi2Boolean logging) {
    callbacks = *given;
    ON_INSTANTIATE;
    return numbers;
}

void fmi2FreeInstance(fmi2Component c) { ON_FREE; }

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_return) {
    ON_STEP;
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t count, fmi2Real value[]) {
    for (size_t i = 0; i < count; i++) value[i] = numbers[vr[i]];
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t count, const fmi2Real value[]) {
    for (size_t i = 0; i < count; i++) numbers[vr[i]] = value[i];
    return fmi2OK;
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t count, fmi2Integer value[]) {
    for (size_t i = 0; i < count; i++) value[i] = whole;
    return fmi2OK;
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t count, const fmi2String categories[]) {
    return fmi2OK;
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean defined, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean ends, fmi2Real stop) {
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return fmi2OK; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return fmi2OK; }
fmi2Status fmi2Terminate(fmi2Component c) { return fmi2OK; }
