# The wall clock is set, forwards and backwards.
. /lab
begin
date -s 2040-01-01
sleep 1
date -s 2020-01-01
sleep 1
end
