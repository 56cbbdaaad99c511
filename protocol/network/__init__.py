"""The network: the transport port, Zenoh behind it, sessions, access rules, queues."""
