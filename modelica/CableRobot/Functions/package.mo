within CableRobot;
package Functions "Calls of the library"
end Functions;
