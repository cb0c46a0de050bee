within CableRobot;
package Interfaces "Connectors"
end Interfaces;
