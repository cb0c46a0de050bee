# SocketCAN as transport and bridge see it: the tests of guest.rs and guest_rig.rs.
virtual_machine --ignored --test-threads=1 --show-output guest
