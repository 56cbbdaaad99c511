from clew.guided.cells import Cell, Seen, View, cells

ALL = View("all", "formed", 1)
LEADER = Seen("member", "leader coordinator", True, "", False, "", 0)
TAIL = Seen("member", "tail", False, "", False, "", 0)


def of(view: View, *fleet: Seen) -> set[Cell]:
    return set(cells(view, fleet))


def test_a_cell_does_not_tell_which_robots_are_in_it_nor_how_many() -> None:
    assert of(ALL, LEADER, TAIL) == of(ALL, TAIL, LEADER)
    assert of(ALL, LEADER, TAIL, TAIL) == of(ALL, LEADER, TAIL)


def test_each_thing_that_a_cell_tells_makes_another_cell() -> None:
    variants = [
        (ALL, TAIL),
        (ALL._replace(may="one"), TAIL),
        (ALL._replace(phase="closing"), TAIL),
        (ALL._replace(turns=2), TAIL),
        (ALL, TAIL._replace(state="aside")),
        (ALL, TAIL._replace(role="middle")),
        (ALL, TAIL._replace(drives=True)),
        (ALL, TAIL._replace(behind="turn")),
        (ALL, TAIL._replace(behind="epoch")),
        (ALL, TAIL._replace(named=True)),
        (ALL, TAIL._replace(trouble="frozen")),
        (ALL, TAIL._replace(silent=1)),
    ]
    assert len({frozenset(of(view, LEADER, each)) for view, each in variants}) == len(variants)


def test_what_a_robot_is_in_depends_on_whether_others_move_and_on_how_many_suffer() -> None:
    calm = TAIL._replace(role="middle")
    assert not of(ALL, calm) <= of(ALL, calm, LEADER)
    assert not of(ALL, calm) <= of(ALL, calm, TAIL._replace(trouble="cut"))


def test_only_pairs_of_which_one_moves_or_may_have_a_cell_of_their_own() -> None:
    aside = TAIL._replace(state="aside")
    assert len(of(ALL, TAIL, aside)) == 2
    assert len(of(ALL, TAIL._replace(named=True), aside)) == 3


def test_cells_are_the_same_on_every_machine() -> None:
    assert sorted(of(ALL, LEADER)) == [0x2DE56280DD9382C]
