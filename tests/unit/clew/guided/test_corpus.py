from clew.guided.corpus import FEW, NEW, Corpus
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


def test_a_cell_counts_once_for_each_run() -> None:
    corpus = Corpus()
    corpus.add([1, 1, 2])
    corpus.merge({2: 3})
    assert corpus.visits == {1: 1, 2: 4}
    assert 1 in corpus
    assert 3 not in corpus
