within CableRobot.Interfaces;
connector BooleanInput = input Boolean "Boolean input; connects to that of the Modelica Standard Library"
  annotation(Icon(coordinateSystem(extent = {{-100, -100}, {100, 100}}), graphics = {Polygon(points = {{-100, 100}, {100, 0}, {-100, -100}}, lineColor = {255, 0, 255}, fillColor = {255, 0, 255}, fillPattern = FillPattern.Solid)}));
