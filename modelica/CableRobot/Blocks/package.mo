within CableRobot;
package Blocks "Controller and planner"
end Blocks;
