#!/bin/sh
# The first and only process of the virtual machine: makes a CAN bus and runs each scenario on it, one after the other.
# What a scenario prints goes to the console between two lines that machine.rs looks for.
/bin/busybox --install -s /busybox
export PATH=/bin:/busybox
mount -t proc none /proc
mount -t sysfs none /sys
mount -t devtmpfs none /dev
mkdir -p /dev/pts /tmp
mount -t devpts none /dev/pts
while read -r module parameters; do insmod "/modules/$module" $parameters; done < /modules/order

for script in /scenarios/*.sh; do
    name=$(basename "$script" .sh)
    ip link add dev vcan0 type vcan
    ip link set up vcan0
    echo "@@ begin $name"
    timeout 200 sh "$script" 2>&1
    echo "@@ end $name $?"
    ip link delete vcan0
done
poweroff -f
