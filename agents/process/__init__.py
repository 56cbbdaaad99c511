"""One robot as a process: shell, host, journal, and failure."""
