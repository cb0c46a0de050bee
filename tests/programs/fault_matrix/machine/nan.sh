# A gateway between bridge and rig turns every reading of load cell 4 into NaN.
. /lab
rig_bus=vcan1
/bin/ip link add dev vcan1 type vcan
/bin/ip link set up vcan1
cangw -A -s vcan0 -d vcan1 -e
cangw -A -s vcan1 -d vcan0 -e -f '18E~C00007FF'
cangw -A -s vcan1 -d vcan0 -e -f 18E:C00007FF
begin
# The new rule before the old one goes: in between, a slow machine would see a silent load cell.
cangw -A -s vcan1 -d vcan0 -e -f 18E:C00007FF -m SET:D:0.0.0000C07F00000000
cangw -D -s vcan1 -d vcan0 -e -f 18E:C00007FF
finish
cangw -F
/bin/ip link delete vcan1
