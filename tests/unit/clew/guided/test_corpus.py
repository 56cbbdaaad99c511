from clew.guided.corpus import FEW, Corpus


def test_an_instant_has_two_futures_while_few_runs_have_reached_its_rarest_cell_and_then_one() -> None:
    corpus = Corpus({10: 900, 11: FEW, 12: FEW + 1})
    assert corpus.worth([10, 13]) == 2
    assert corpus.worth([10, 11]) == 2
    assert corpus.worth([10, 12]) == 1


def test_a_cell_counts_once_for_each_run() -> None:
    corpus = Corpus()
    corpus.add([1, 1, 2])
    corpus.merge({2: 3})
    assert corpus.visits == {1: 1, 2: 4}
    assert 1 in corpus
    assert 3 not in corpus
