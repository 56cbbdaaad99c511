"""What goes wrong on purpose: fault plans, and what they do to messages and processes. Live and rehearsed."""
