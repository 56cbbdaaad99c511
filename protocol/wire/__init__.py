"""What goes over the wire: messages, their bytes, and what a link grants."""
