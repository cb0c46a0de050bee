within CableRobot.Blocks;
block Controller "Controller and planner: pose in, motor tensions out"
  parameter String rigFile = "" "Path of a rig file; empty: the paper's rig";
  parameter Integer cables = 6 "Number of cables of that rig";
  parameter Real samplePeriod(unit = "s", min = 0) = 0.001 "Between two steps; the tensions are held meanwhile";
  parameter Real lambda(unit = "1/s", min = 0) = 3 "Gain of Eq. (2)";
  parameter Real eta(unit = "1/s", min = 0) = 3 "Gain of Eq. (4)";
  parameter Integer planner(min = 1, max = 2) = 1 "1: Bounded, the paper's; 2: Exact, for any rig";
  parameter Real plannerPeriod(unit = "s", min = 0) = 0.05 "Between two decisions of the planner";
  parameter Real minTension(unit = "N", min = 0) = 0 "Least tension of each cable";
  parameter Real maxTension(unit = "N", min = 0) = 0 "Greatest tension of each cable; 0: the rig's";
  parameter Real commandDelay(unit = "s", min = 0) = 0 "From a measurement to the moment at which its command acts";
  parameter Real observerBound(min = 0, max = 1) = 0.1 "Largest constant force that is made up for, as a share of the weight";
  CableRobot.Interfaces.RealInput encoderPose[6] "Measured pose, m and rad"
    annotation(Placement(transformation(extent = {{-140, 40}, {-100, 80}})));
  CableRobot.Interfaces.RealInput goalPose[6] "Goal, m and rad"
    annotation(Placement(transformation(extent = {{-140, -20}, {-100, 20}})));
  CableRobot.Interfaces.BooleanInput enable "Whether the controller may pull"
    annotation(Placement(transformation(extent = {{-140, -80}, {-100, -40}})));
  CableRobot.Interfaces.RealOutput motorTension[cables](each start = 0) "What the motors shall pull, N"
    annotation(Placement(transformation(extent = {{100, 50}, {120, 70}})));
  CableRobot.Interfaces.RealOutput setPoint[6](each start = 0) "The active set point, m and rad"
    annotation(Placement(transformation(extent = {{100, 10}, {120, 30}})));
  CableRobot.Interfaces.RealOutput tensionMargin(start = 0) "Smallest tension predicted from now on, N"
    annotation(Placement(transformation(extent = {{100, -30}, {120, -10}})));
  CableRobot.Interfaces.IntegerOutput status(start = 1) "1 Disabled, 2 Holding, 3 Moving, 4 AtGoal, 5 GoalUnreachable, 6 SensorFault, 7 WaitingForPose"
    annotation(Placement(transformation(extent = {{100, -70}, {120, -50}})));
protected
  CableRobot.Types.Controller controller = CableRobot.Types.Controller(
    rigFile, lambda, eta, planner, plannerPeriod, minTension, maxTension, commandDelay, observerBound);
algorithm
  when sample(0, samplePeriod) then
    (motorTension, setPoint, tensionMargin, status) := CableRobot.Functions.controllerStep(
      controller, time, samplePeriod, encoderPose, goalPose, enable, cables);
  end when;
  annotation(
    Documentation(info = "<html><p>The whole controller of cable-robot, the same as in the FMU, sampled every <code>samplePeriod</code>. What is no parameter here is as there by default.</p></html>"),
    Icon(
      coordinateSystem(extent = {{-100, -100}, {100, 100}}),
      graphics = {
        Rectangle(extent = {{-100, 100}, {100, -100}}, lineColor = {0, 0, 127}, fillColor = {255, 255, 255}, fillPattern = FillPattern.Solid),
        Text(extent = {{-90, 30}, {90, -30}}, textString = "controller", textColor = {0, 90, 160}),
        Text(extent = {{-100, 140}, {100, 104}}, textString = "%name", textColor = {0, 0, 255})}));
end Controller;
