from clew.guided.corpus import Choice, Corpus, Held


def held(slot: int, *cells: int, played: int = 0) -> Held:
    return Held(slot, 1.0, frozenset(cells), 0, played)


def test_the_run_with_the_rarest_cell_is_gone_on_from_first() -> None:
    corpus = Corpus({10: 9, 11: 1, 12: 3})
    choice = Choice(corpus, 3, [held(0, 10), held(1, 10, 11), held(2, 12)])
    assert choice.best() is choice.held[1]
    assert choice.worst() is choice.held[0]


def test_each_future_halves_what_a_run_is_worth_and_none_has_more_than_its_number() -> None:
    corpus = Corpus({10: 1, 11: 3})
    first, second = held(0, 10), held(1, 11)
    choice = Choice(corpus, 3, [first, second])
    order = []
    while (best := choice.best()) is not None:
        order.append(best.slot)
        best.played += 1
    assert order == [0, 0, 1, 0, 1, 1]


def test_equally_rare_runs_differ_in_worth_by_less_than_two_times() -> None:
    corpus = Corpus(dict.fromkeys(range(100), 1))
    worths = {held(slot, slot).worth(corpus) for slot in range(100)}
    assert len(worths) == 100
    assert max(worths) < 2.0 * min(worths)


def test_a_cell_counts_once_for_each_run() -> None:
    corpus = Corpus()
    corpus.add([1, 1, 2])
    corpus.merge({2: 3})
    assert corpus.visits == {1: 1, 2: 4}
    assert 1 in corpus
    assert 3 not in corpus
