"""How long a test waits before it counts as hung.

Deadlines only detect hangs. Everything that works, even a whole run, takes less than a twentieth of this, so
a slow machine meets it, too: on one core, at a load of 20, the longest test took 141 s. No test asserts a
duration: `clew bench` measures those.
"""

DEADLINE_S = 300.0
