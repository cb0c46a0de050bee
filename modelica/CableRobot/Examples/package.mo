within CableRobot;
package Examples "Examples"
end Examples;
