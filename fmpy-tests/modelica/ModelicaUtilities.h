/* What a Modelica tool brings: here the error ends the program with code 3, after its message on stderr. */
#ifndef MODELICA_UTILITIES_H
#define MODELICA_UTILITIES_H
void ModelicaFormatError(const char* format, ...);
#endif
