within CableRobot;
class UsersGuide "User's Guide"
  annotation(
    DocumentationClass = true,
    preferredView = "info",
    Documentation(info = "<html>
<h4>What is here</h4>
<ul>
<li><a href=\"modelica://CableRobot.Plants.Plant\">Plants.Plant</a>: the robot, a rigid body on six <a href=\"modelica://CableRobot.Plants.Cable\">cables</a>, in plain equations. It needs no external code. A cable pulls
or is slack, it never pushes.</li>
<li><a href=\"modelica://CableRobot.Blocks.Controller\">Blocks.Controller</a>: controller and planner in one, pose in, motor tensions out. It calls the library in Resources/Library by external C.</li>
<li><a href=\"modelica://CableRobot.Blocks.Planner\">Blocks.Planner</a>: the planner alone.</li>
<li><a href=\"modelica://CableRobot.Examples\">Examples</a>: the paper's move, and the plant alone.</li>
</ul>
<h4>Conventions</h4>
<p>The frame is that of the rig; for the paper's rig its origin is the middle of the base plane and z points down. SI units, radians. A pose is
x, y, z of the centre of mass and roll, pitch, yaw with R = Rz(yaw) Ry(pitch) Rx(roll).</p>
<h4>Other rigs</h4>
<p>Controller and planner take the path of a rig file as <code>rigFile</code>; empty is the paper's rig. The plant takes anchors and attachments of
six cables, mass, inertia about the platform's axes and gravity as parameters.</p>
<h4>FMUs beside it</h4>
<p>The same controller and plant come as FMUs for co-simulation (FMI 2 and 3). How an FMU is imported differs between tools; imported, it has the same variables
under the names of its own documentation.</p>
<h4>What was tried</h4>
<p>The plant is compiled and simulated by rumoca and compared with the plant FMU; all files are parsed by pymoca and by rumoca. The external functions are called from C as they are declared here and compared with the
controller FMU bit for bit. Nothing of this was run in Dymola or OpenModelica: neither was at hand.</p>
</html>"));
end UsersGuide;
