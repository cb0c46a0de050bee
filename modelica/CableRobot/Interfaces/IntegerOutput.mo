within CableRobot.Interfaces;
connector IntegerOutput = output Integer "Integer output; connects to that of the Modelica Standard Library"
  annotation(Icon(coordinateSystem(extent = {{-100, -100}, {100, 100}}), graphics = {Polygon(points = {{-100, 100}, {100, 0}, {-100, -100}}, lineColor = {255, 127, 0}, fillColor = {255, 127, 0}, fillPattern = FillPattern.Solid)}));
