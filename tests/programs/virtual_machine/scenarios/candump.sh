# What another program writes about the bus, for the host to read with our parser.
candump -L -n 4 vcan0,0:0,#FFFFFFFF > /tmp/log &
sleep 0.5
cansend vcan0 181#0011223344556677
cansend vcan0 701#R1
cansend vcan0 080#
cansend vcan0 20000040#0000000000000000
wait
cat /tmp/log
