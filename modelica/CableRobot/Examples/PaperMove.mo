within CableRobot.Examples;
model PaperMove "The paper's move from (0, 0, 1) to (0.15, 0.15, 1), closed loop"
  CableRobot.Plants.Plant plant annotation(Placement(transformation(extent = {{20, -20}, {60, 20}})));
  CableRobot.Blocks.Controller controller annotation(Placement(transformation(extent = {{-60, -20}, {-20, 20}})));
equation
  controller.goalPose = {0.15, 0.15, 1, 0, 0, 0};
  controller.enable = true;
  connect(controller.motorTension, plant.motorTension) annotation(Line(points = {{-18, 12}, {16, 0}}, color = {0, 0, 127}));
  connect(plant.encoderPose, controller.encoderPose) annotation(Line(points = {{62, 12}, {80, 40}, {-80, 40}, {-64, 12}}, color = {0, 0, 127}));
  annotation(experiment(StartTime = 0, StopTime = 9, Interval = 0.01, Tolerance = 1e-8));
end PaperMove;
