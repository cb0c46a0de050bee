within CableRobot.Functions;
impure function plannerStep "The set point to give now"
  input CableRobot.Types.Planner planner;
  input Real pose[6];
  input Real rates[6] "Of the six coordinates";
  input Real active[6] "The active set point";
  input Real goal[6];
  input Real hold(unit = "s") "For how long commands are held";
  output Real setPoint[6];
  external "C" CableRobot_planner_step(planner, pose, rates, active, goal, hold, setPoint)
    annotation(
      Include = "#include \"CableRobot.h\"",
      Library = "CableRobot");
end plannerStep;
