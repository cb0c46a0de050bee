within ;
package CableRobot "Cable-suspended robots that never let a cable go slack"
  annotation(
    version = "0.1.0",
    versionDate = "2026-11-27",
    preferredView = "info",
    Documentation(info = "<html>
<p>Controller, planner and plant of cable-suspended robots. The plant is plain Modelica; controller and planner call the library that is also
in the FMUs. Begin with the <a href=\"modelica://CableRobot.UsersGuide\">User's Guide</a>.</p>
</html>"),
    Icon(
      coordinateSystem(extent = {{-100, -100}, {100, 100}}),
      graphics = {
        Rectangle(extent = {{-100, 100}, {100, -100}}, lineColor = {95, 95, 95}, fillColor = {255, 255, 255}, fillPattern = FillPattern.Solid, radius = 20),
        Line(points = {{-80, 80}, {-20, -40}, {0, 80}, {20, -40}, {80, 80}}, color = {0, 90, 160}, thickness = 1),
        Rectangle(extent = {{-30, -40}, {30, -60}}, lineColor = {60, 60, 60}, fillColor = {170, 170, 170}, fillPattern = FillPattern.Solid)}));
end CableRobot;
