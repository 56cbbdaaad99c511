from clew.guided.corpus import FEW, NEW, Corpus, Instant
from clew.swarm.draws import Draws


def draws(seed: int = 1) -> Draws:
    return Draws(seed, "test")


def test_an_instant_is_worth_as_much_as_its_rarest_cell_is_rare() -> None:
    corpus = Corpus({10: 900, 11: FEW})
    assert corpus.worth([10, 12], draws()) == NEW
    assert corpus.worth([10, 11], draws()) == 1
    assert corpus.worth([], draws()) == 0


def test_where_many_have_been_an_instant_has_a_future_now_and_then() -> None:
    corpus = Corpus({10: 10 * FEW, 11: 1000 * FEW})
    assert 40 < sum(corpus.worth([10], draws(seed)) for seed in range(200)) < 80
    assert 20 < sum(corpus.worth([11], draws(seed)) for seed in range(200)) < 80


def at(t_s: float, *cells: int, view_changes: bool = False) -> Instant:
    return Instant(round(t_s * 50), t_s, frozenset(cells), view_changes)


def test_of_a_run_the_rarest_instants_count_in_order_and_apart() -> None:
    corpus = Corpus({10: 9, 11: 1, 12: 3})
    first, second, third, near = at(1.0, 10), at(2.0, 12, 10), at(3.0, 11), at(3.2, 13)
    everything = [first, second, third, near]
    assert corpus.rarest(everything, 2, 0.1) == [third, near]
    assert corpus.rarest(everything, 2, 0.3) == [second, near]
    assert corpus.rarest(everything, 9, 0.3) == [first, second, near]


def test_of_equally_rare_instants_those_at_which_a_view_forms_come_first() -> None:
    corpus = Corpus({10: 4, 11: 7, 12: 8})
    calm, forming, known = at(1.0, 10), at(2.0, 11, view_changes=True), at(3.0, 12, view_changes=True)
    assert corpus.rarest([calm, forming, known], 1, 0.1) == [forming]
    assert corpus.rarest([calm, known], 1, 0.1) == [calm]
    assert corpus.rarest([at(5.0, 11), at(4.0, 10)], 1, 0.1) == [at(4.0, 10)]


def test_a_cell_counts_once_for_each_run() -> None:
    corpus = Corpus()
    corpus.add([1, 1, 2])
    corpus.merge({2: 3})
    assert corpus.visits == {1: 1, 2: 4}
    assert 1 in corpus
    assert 3 not in corpus
