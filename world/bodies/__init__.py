"""The bodies of robots: how they move, what they sense."""
