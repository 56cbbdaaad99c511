"""How long a test waits for what does not come.

Deadlines are for hangs alone: nothing that works takes a tenth of this, not even a whole run, so a slow
machine meets it, too. No test asserts how long something took: `clew bench` measures that.
"""

DEADLINE_S = 120.0
