# The interface is switched off.
. /lab
begin
/bin/ip link set down vcan0
finish
