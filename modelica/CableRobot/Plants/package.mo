within CableRobot;
package Plants "Robots in plain Modelica"
end Plants;
