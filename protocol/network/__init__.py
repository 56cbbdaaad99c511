"""How it goes over the network: the port, Zenoh behind it, sessions, access, queues."""
