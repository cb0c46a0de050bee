within CableRobot.Interfaces;
connector RealOutput = output Real "Real output; connects to that of the Modelica Standard Library"
  annotation(Icon(coordinateSystem(extent = {{-100, -100}, {100, 100}}), graphics = {Polygon(points = {{-100, 100}, {100, 0}, {-100, -100}}, lineColor = {0, 0, 127}, fillColor = {0, 0, 127}, fillPattern = FillPattern.Solid)}));
