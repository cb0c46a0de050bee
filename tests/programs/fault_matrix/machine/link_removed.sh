# The interface is taken away.
. /lab
begin
/bin/ip link delete vcan0
finish
/bin/ip link add dev vcan0 type vcan
