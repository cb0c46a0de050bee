  annotation(
    Documentation(info = "<html><p>Newton and Euler's equations of a rigid body with 13 states; the quaternion's length is divided out. No friction, no lag, no noise: the plant FMU has those.</p></html>"),
    Icon(
      coordinateSystem(extent = {{-100, -100}, {100, 100}}),
      graphics = {
        Rectangle(extent = {{-100, 100}, {100, -100}}, lineColor = {60, 60, 60}, fillColor = {255, 255, 255}, fillPattern = FillPattern.Solid),
        Line(points = {{-80, 80}, {-20, -30}, {0, 80}, {20, -30}, {80, 80}}, color = {0, 90, 160}, thickness = 1),
        Rectangle(extent = {{-30, -30}, {30, -50}}, lineColor = {60, 60, 60}, fillColor = {170, 170, 170}, fillPattern = FillPattern.Solid),
        Text(extent = {{-100, 140}, {100, 104}}, textString = "%name", textColor = {0, 0, 255})}));
