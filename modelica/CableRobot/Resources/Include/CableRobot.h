/* Controller and planner of cable-robot for Modelica's external objects. The functions of the library answer 0, or another number and a
 * message; the functions CableRobot_... below hand the message to the Modelica tool. */
#ifndef CABLE_ROBOT_H
#define CABLE_ROBOT_H

#include <stddef.h>
#include "ModelicaUtilities.h"

#ifdef __cplusplus
extern "C" {
#endif

int cable_robot_controller_create(void** object, const char* rig_file, double lambda, double eta, int planner, double planner_period,
    double least_tension, double greatest_tension, double command_delay, double observer_bound, char* message, size_t size);
void cable_robot_controller_free(void* object);
int cable_robot_controller_step(void* object, double time, double hold, const double* pose, const double* goal, int enable,
    double* motor_tension, size_t cables, double* set_point, double* tension_margin, int* status, char* message, size_t size);

int cable_robot_planner_create(void** object, const char* rig_file, double lambda, double eta, int planner, double least_tension,
    double greatest_tension, char* message, size_t size);
void cable_robot_planner_free(void* object);
int cable_robot_planner_step(const void* object, const double* pose, const double* rates, const double* active, const double* goal,
    double hold, double* set_point, char* message, size_t size);

#ifdef __cplusplus
}
#endif

#define CABLE_ROBOT_MESSAGE 512

static void* CableRobot_controller(const char* rig_file, double lambda, double eta, int planner, double planner_period, double least_tension,
    double greatest_tension, double command_delay, double observer_bound) {
  char message[CABLE_ROBOT_MESSAGE];
  void* object = NULL;
  if (cable_robot_controller_create(&object, rig_file, lambda, eta, planner, planner_period, least_tension, greatest_tension, command_delay,
          observer_bound, message, sizeof message) != 0) {
    ModelicaFormatError("CableRobot controller: %s\n", message);
  }
  return object;
}

static void CableRobot_controller_step(void* object, double time, double hold, const double* pose, const double* goal, int enable,
    double* motor_tension, size_t cables, double* set_point, double* tension_margin, int* status) {
  char message[CABLE_ROBOT_MESSAGE];
  if (cable_robot_controller_step(object, time, hold, pose, goal, enable, motor_tension, cables, set_point, tension_margin, status, message,
          sizeof message) != 0) {
    ModelicaFormatError("CableRobot controller at %g s: %s\n", time, message);
  }
}

static void* CableRobot_planner(const char* rig_file, double lambda, double eta, int planner, double least_tension, double greatest_tension) {
  char message[CABLE_ROBOT_MESSAGE];
  void* object = NULL;
  if (cable_robot_planner_create(&object, rig_file, lambda, eta, planner, least_tension, greatest_tension, message, sizeof message) != 0) {
    ModelicaFormatError("CableRobot planner: %s\n", message);
  }
  return object;
}

static void CableRobot_planner_step(void* object, const double* pose, const double* rates, const double* active, const double* goal,
    double hold, double* set_point) {
  char message[CABLE_ROBOT_MESSAGE];
  if (cable_robot_planner_step(object, pose, rates, active, goal, hold, set_point, message, sizeof message) != 0) {
    ModelicaFormatError("CableRobot planner: %s\n", message);
  }
}

#endif
