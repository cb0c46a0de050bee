/* Calls constructor, step and destructor as the Modelica package declares them. Arguments: planner, lambda, rig file. Each line of stdin is
 * time, hold, six of the pose and six of the goal; answered by what two controllers and a planner say, as hexadecimal floats. */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "CableRobot.h"

void ModelicaFormatError(const char* format, ...) {
  va_list arguments;
  va_start(arguments, format);
  vfprintf(stderr, format, arguments);
  va_end(arguments);
  exit(3);
}

int main(int count, char** values) {
  const int planner = atoi(values[1]);
  const double lambda = atof(values[2]);
  const char* rig = count > 3 ? values[3] : "";
  void* controllers[2];
  for (int k = 0; k < 2; k++) controllers[k] = CableRobot_controller(rig, lambda, 3.0, planner, 0.05, 0.0, 0.0, 0.0, 0.1);
  void* planning = CableRobot_planner(rig, lambda, 3.0, planner, 0.0, 0.0);
  double in[14];
  for (;;) {
    for (int k = 0; k < 14; k++) {
      if (scanf("%la", &in[k]) != 1) goto end;
    }
    for (int k = 0; k < 2; k++) {
      double tension[6], set_point[6], margin;
      int status;
      CableRobot_controller_step(controllers[k], in[0], in[1], in + 2, in + 8, 1, tension, 6, set_point, &margin, &status);
      for (int i = 0; i < 6; i++) printf("%a ", tension[i]);
      for (int i = 0; i < 6; i++) printf("%a ", set_point[i]);
      printf("%a %d ", margin, status);
    }
    const double at_rest[6] = {0, 0, 0, 0, 0, 0};
    double next[6];
    CableRobot_planner_step(planning, in + 2, at_rest, in + 2, in + 8, 0.001, next);
    for (int i = 0; i < 6; i++) printf("%a ", next[i]);
    printf("\n");
  }
end:
  for (int k = 0; k < 2; k++) cable_robot_controller_free(controllers[k]);
  cable_robot_planner_free(planning);
  return 0;
}
