# The controller of the bus reports that it is off.
. /lab
begin
cansend vcan0 20000040#0004000000000000
finish
