import subprocess
import sys

from tests.support.deadline import DEADLINE_S

BLOCKS, BLOCK_BYTES = 40, 1 << 18
PROGRAM = f"""
import ctypes
import sys
import numpy as np
from protocol.process.allocation import _Info, return_large_blocks

mallinfo2 = ctypes.CDLL(None).mallinfo2
mallinfo2.restype = _Info

def had_bytes():  # from the system: what of it is in memory also hangs on the kernel
    info = mallinfo2()
    return info.arena + info.hblkhd

if sys.argv[1] == "returns":
    return_large_blocks()
for _ in range(2):  # the second time glibc has learned how large blocks are
    before = had_bytes()
    blocks = [np.ones({BLOCK_BYTES}, dtype=np.uint8) for _ in range({BLOCKS})]
    pins = [np.ones(1000) for _ in range(10)]  # at the heap's end, where they keep it from shrinking
    blocks.clear()
print(had_bytes() - before)
"""

NAMES = 100
NAMES_PROGRAM = f"""
import sys
from protocol.process.allocation import forget_lookups

class Looked:
    pass

names = ["looked up " + str(each) for each in range({NAMES})]
before = sum(map(sys.getrefcount, names))
for each in range({NAMES}):
    getattr(Looked, names[each], None)
if sys.argv[1] == "forgets":
    forget_lookups()
print(sum(map(sys.getrefcount, names)) - before)
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


def told_by(program: str, how: str) -> int:
    command = [sys.executable, "-c", program, how]
    said = subprocess.run(command, check=True, capture_output=True, timeout=DEADLINE_S, text=True)
    return int(said.stdout)


def filled_holes(how: str) -> int:
    """In how many holes later blocks lie."""
    return told_by(HOLES_PROGRAM, how)


def test_later_blocks_lie_in_no_holes_when_these_are_filled() -> None:
    assert filled_holes("fills") == 0
    assert filled_holes("leaves") > HOLES / 10


def kept_bytes(how: str) -> int:
    return told_by(PROGRAM, how)


def test_large_blocks_go_back_to_the_system_when_they_are_freed() -> None:
    assert kept_bytes("returns") < BLOCKS * BLOCK_BYTES / 4 < kept_bytes("keeps")


def test_python_refers_to_no_name_that_it_has_looked_up_when_lookups_are_forgotten() -> None:
    assert told_by(NAMES_PROGRAM, "keeps") > NAMES / 2  # some take the place of others
    assert told_by(NAMES_PROGRAM, "forgets") == 0
