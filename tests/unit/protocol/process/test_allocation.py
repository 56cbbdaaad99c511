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


HOLES = 2000
HOLES_PROGRAM = f"""
import ctypes
import sys
from protocol.process.allocation import fill_holes

libc = ctypes.CDLL(None)
libc.malloc.restype, libc.free.argtypes = ctypes.c_size_t, (ctypes.c_size_t,)
blocks = [libc.malloc(1100 + 20 * (each % 50)) for each in range({HOLES})]
holes = set(blocks[::2])
for block in holes:
    libc.free(block)
if sys.argv[1] == "fills":
    fill_holes()
print(len(holes & {{libc.malloc(1100) for _ in range({HOLES})}}))
"""


def filled_holes(how: str) -> int:
    """In how many holes later blocks lie."""
    program = [sys.executable, "-c", HOLES_PROGRAM, how]
    return int(subprocess.run(program, check=True, capture_output=True, text=True).stdout)


def test_later_blocks_lie_in_no_holes_when_these_are_filled() -> None:
    assert filled_holes("fills") == 0
    assert filled_holes("leaves") > HOLES / 10


def kept_bytes(how: str) -> int:
    said = subprocess.run([sys.executable, "-c", PROGRAM, how], check=True, capture_output=True, text=True)
    return int(said.stdout)


def test_large_blocks_go_back_to_the_system_when_they_are_freed() -> None:
    assert kept_bytes("returns") < BLOCKS * BLOCK_BYTES / 4 < kept_bytes("keeps")
