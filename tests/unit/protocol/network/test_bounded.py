"""The bounded queue: the newest items that fit are kept in order, and every other one is counted."""

from hypothesis import given
from hypothesis import strategies as st

from protocol.network.bounded import Bounded

Item = tuple[int, int]  # its place, and its size


def fitting(items: list[Item], capacity: int, bytes_max: int) -> list[Item]:
    """The newest items that fit together."""
    kept: list[Item] = []
    for item in reversed(items):
        if len(kept) == capacity or sum(size for _, size in [*kept, item]) > bytes_max:
            break
        kept.append(item)
    return kept[::-1]


@given(st.lists(st.integers(0, 50), max_size=60), st.integers(1, 8), st.integers(1, 120))
def test_the_newest_that_fit_are_kept_in_order_and_all_others_are_counted(
    sizes: list[int], capacity: int, bytes_max: int
) -> None:
    queue = Bounded[Item](capacity=capacity, bytes_max=bytes_max)
    items = list(enumerate(sizes))
    for item in items:
        queue.append(item, item[1])
    # Where one item alone is larger than the bound, all before it are gone, too.
    too_large = [place for place, size in items if size > bytes_max]
    later = items[too_large[-1] + 1 :] if too_large else items
    assert len(queue) == len(fitting(later, capacity, bytes_max))
    assert queue.drain() == fitting(later, capacity, bytes_max)
    assert queue.dropped_count == len(items) - len(fitting(later, capacity, bytes_max))


def test_an_empty_queue_has_room_for_all_its_bytes_again() -> None:
    queue = Bounded[str](capacity=9, bytes_max=10)
    queue.append("a", 10)
    assert queue.drain() == ["a"]
    queue.append("b", 10)
    assert (queue.drain(), queue.dropped_count) == (["b"], 0)
