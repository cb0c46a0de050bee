within CableRobot.Types;
class Planner "A planner"
  extends ExternalObject;
  function constructor "Makes it"
    input String rigFile "Path of a rig file; empty: the paper's rig";
    input Real lambda;
    input Real eta;
    input Integer planner;
    input Real minTension;
    input Real maxTension;
    output Planner object;
    external "C" object = CableRobot_planner(rigFile, lambda, eta, planner, minTension, maxTension)
    annotation(
      Include = "#include \"CableRobot.h\"",
      Library = "CableRobot");
  end constructor;
  function destructor "Frees it"
    input Planner object;
    external "C" cable_robot_planner_free(object)
    annotation(
      Include = "#include \"CableRobot.h\"",
      Library = "CableRobot");
  end destructor;
end Planner;
