within CableRobot.Functions;
impure function controllerStep "One step of the controller"
  input CableRobot.Types.Controller controller;
  input Real time_(unit = "s") "Time of the measurement";
  input Real hold(unit = "s") "For how long the tensions will be held";
  input Real pose[6] "Measured pose";
  input Real goal[6];
  input Boolean enable;
  input Integer cables;
  output Real motorTension[cables](each unit = "N");
  output Real setPoint[6];
  output Real tensionMargin(unit = "N");
  output Integer status;
  external "C" CableRobot_controller_step(controller, time_, hold, pose, goal, enable, motorTension, size(motorTension, 1), setPoint, tensionMargin, status)
    annotation(
      Include = "#include \"CableRobot.h\"",
      Library = "CableRobot");
end controllerStep;
