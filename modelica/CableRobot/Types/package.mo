within CableRobot;
package Types "Objects that the library keeps"
end Types;
