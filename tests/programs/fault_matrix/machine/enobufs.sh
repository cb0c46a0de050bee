# No room in the queue of the interface: a bus that takes 30 frames a second.
. /lab
begin
/bin/tc qdisc add dev vcan0 root tbf rate 4kbit burst 32 limit 64
finish
