within CableRobot.Blocks;
block Planner "The planner alone: set points on the way to a goal"
  parameter String rigFile = "" "Path of a rig file; empty: the paper's rig";
  parameter Real plannerPeriod(unit = "s", min = 0) = 0.05 "Between two decisions";
  parameter Real lambda(unit = "1/s", min = 0) = 3 "Gain of Eq. (2)";
  parameter Real eta(unit = "1/s", min = 0) = 3 "Gain of Eq. (4)";
  parameter Integer planner(min = 1, max = 2) = 1 "1: Bounded, the paper's; 2: Exact, for any rig";
  parameter Real minTension(unit = "N", min = 0) = 0 "Least tension of each cable";
  parameter Real maxTension(unit = "N", min = 0) = 0 "Greatest tension of each cable; 0: the rig's";
  parameter Real hold(unit = "s", min = 0) = 0.001 "For how long the law holds its commands";
  parameter Real initialSetPoint[6] = {0, 0, 1, 0, 0, 0} "Where the robot rests at the start, m and rad";
  CableRobot.Interfaces.RealInput pose[6] "m and rad" annotation(Placement(transformation(extent = {{-140, 40}, {-100, 80}})));
  CableRobot.Interfaces.RealInput rates[6] "Of the six coordinates, m/s and rad/s" annotation(Placement(transformation(extent = {{-140, -20}, {-100, 20}})));
  CableRobot.Interfaces.RealInput goalPose[6] "m and rad" annotation(Placement(transformation(extent = {{-140, -80}, {-100, -40}})));
  CableRobot.Interfaces.RealOutput setPoint[6](start = initialSetPoint, each fixed = true) "The active set point, m and rad"
    annotation(Placement(transformation(extent = {{100, -10}, {120, 10}})));
protected
  CableRobot.Types.Planner object = CableRobot.Types.Planner(rigFile, lambda, eta, planner, minTension, maxTension);
algorithm
  when sample(0, plannerPeriod) then
    setPoint := CableRobot.Functions.plannerStep(object, pose, rates, pre(setPoint), goalPose, hold);
  end when;
  annotation(
    Icon(
      coordinateSystem(extent = {{-100, -100}, {100, 100}}),
      graphics = {
        Rectangle(extent = {{-100, 100}, {100, -100}}, lineColor = {0, 0, 127}, fillColor = {255, 255, 255}, fillPattern = FillPattern.Solid),
        Text(extent = {{-90, 30}, {90, -30}}, textString = "planner", textColor = {0, 90, 160}),
        Text(extent = {{-100, 140}, {100, 104}}, textString = "%name", textColor = {0, 0, 255})}));
end Planner;
