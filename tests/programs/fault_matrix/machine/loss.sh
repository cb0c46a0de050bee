# One frame of a hundred is lost.
. /lab
begin
/bin/tc qdisc add dev vcan0 root netem loss 1%
sleep 5
end
