"""What two processes of a fleet must agree on: keys, messages, links, transport."""
