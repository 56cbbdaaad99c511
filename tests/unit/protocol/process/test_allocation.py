import subprocess
import sys

BLOCKS, BLOCK_BYTES = 40, 1 << 18
PROGRAM = f"""
import sys
import numpy as np
from protocol.process.allocation import return_large_blocks

def resident_bytes():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * 4096

if sys.argv[1] == "returns":
    return_large_blocks()
for _ in range(2):  # the second time glibc has learned how large blocks are
    before = resident_bytes()
    blocks = [np.ones({BLOCK_BYTES}, dtype=np.uint8) for _ in range({BLOCKS})]
    pins = [np.ones(1000) for _ in range(10)]  # at the heap's end, where they keep it from shrinking
    blocks.clear()
print(resident_bytes() - before)
"""


def kept_bytes(how: str) -> int:
    said = subprocess.run([sys.executable, "-c", PROGRAM, how], check=True, capture_output=True, text=True)
    return int(said.stdout)


def test_large_blocks_go_back_to_the_system_when_they_are_freed() -> None:
    assert kept_bytes("returns") < BLOCKS * BLOCK_BYTES / 4 < kept_bytes("keeps")
