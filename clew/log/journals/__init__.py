"""What the journals of a run's robots tell: messages and their ways, the cores' states, causes."""
