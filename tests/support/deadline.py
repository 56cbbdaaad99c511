"""How long a test waits before it counts as hung.

Deadlines only detect hangs. Everything that works, even a whole run, takes less than a tenth of this, so a
slow machine meets it, too. No test asserts a duration: `clew bench` measures those.
"""

DEADLINE_S = 120.0
