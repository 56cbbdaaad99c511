"""One robot as a process: its shell, its host, its journal, and how it fails."""
