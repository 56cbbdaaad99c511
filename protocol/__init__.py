"""The protocol between the processes of a fleet: keys, messages, links, transport, timeline, faults."""
