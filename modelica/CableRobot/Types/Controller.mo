within CableRobot.Types;
class Controller "A controller with all its memory"
  extends ExternalObject;
  function constructor "Makes it"
    input String rigFile "Path of a rig file; empty: the paper's rig";
    input Real lambda;
    input Real eta;
    input Integer planner;
    input Real plannerPeriod;
    input Real minTension;
    input Real maxTension;
    input Real commandDelay;
    input Real observerBound;
    output Controller controller;
    external "C" controller = CableRobot_controller(rigFile, lambda, eta, planner, plannerPeriod, minTension, maxTension, commandDelay, observerBound)
    annotation(
      Include = "#include \"CableRobot.h\"",
      Library = "CableRobot");
  end constructor;
  function destructor "Frees it"
    input Controller controller;
    external "C" cable_robot_controller_free(controller)
    annotation(
      Include = "#include \"CableRobot.h\"",
      Library = "CableRobot");
  end destructor;
end Controller;
