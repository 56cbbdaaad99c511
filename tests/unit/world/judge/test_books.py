from protocol.timeline import Entry, FaultInjected, Record, TrafficCounted
from world.judge.books import Messages, balance
from world.judge.tally import Tally


def account(
    sent: dict[str, int] | None = None,
    received: dict[str, int] | None = None,
    newest: dict[str, int] | None = None,
    injected: dict[str, dict[str, int]] | None = None,
    refused: dict[str, int] | None = None,
) -> TrafficCounted:
    return TrafficCounted(
        sent=sent or {},
        received=received or {},
        newest=newest or received or {},
        injected=injected or {},
        refused=refused or {},
        overflowed=0,
        unrecorded=0,
    )


def books(**accounts: TrafficCounted) -> Messages:
    everybody = {name: account() for name in ("world", "r1", "r2", "r3")} | accounts
    return balance(everybody)


def test_sent_and_received_messages_balance() -> None:
    link, drive = "link/r1/r2", "body/r2/drive"
    messages = books(
        r1=account(sent={link: 5}),
        r2=account(sent={drive: 7}, received={link: 5}),
        world=account(received={drive: 7}),
    )
    assert (messages.sent, messages.received, messages.unaccounted) == (12, 12, 0)
    assert messages.left_out == ()


def test_a_lost_message_is_unaccounted_even_when_it_was_the_last() -> None:
    link = "link/r1/r2"
    messages = books(r1=account(sent={link: 5}), r2=account(received={link: 4}, newest={link: 4}))
    assert messages.unaccounted == 1


def test_messages_removed_by_a_fault_plan_are_accounted_for_by_fault() -> None:
    link, view = "link/r1/r2", "view/r1/r3"
    messages = books(
        r1=account(sent={link: 9, view: 4}),
        r2=account(
            received={link: 5},
            newest={link: 9},
            injected={"drop": {link: 2}, "corrupt": {link: 1}},
        ),
        r3=account(received={view: 2}, newest={view: 4}, injected={"drop": {view: 2}}),
    )
    assert (messages.sent, messages.received, messages.unaccounted) == (13, 7, 1)
    assert messages.injected == {"corrupt": 1, "drop": 4}


def test_a_refused_message_counts_as_a_missing_one_or_as_foreign() -> None:
    link, drive = "link/r1/r2", "body/r1/drive"
    damaged = account(received={link: 3}, newest={link: 5}, refused={link: 1})
    forged = account(received={drive: 2}, newest={drive: 2}, refused={drive: 40})
    messages = books(r1=account(sent={link: 5, drive: 2}), r2=damaged, world=forged)
    assert (messages.sent, messages.received, messages.refused, messages.unaccounted) == (7, 5, 1, 1)


def test_keys_whose_messages_were_all_removed_are_in_the_books() -> None:
    drive = "body/r1/drive"
    messages = books(
        r1=account(sent={drive: 3}),
        world=account(newest={drive: 3}, injected={"partition": {drive: 3}}),
    )
    assert (messages.sent, messages.received, messages.unaccounted) == (3, 0, 0)


def test_messages_of_views_and_to_the_fence_are_in_the_books() -> None:
    view, fence = "view/r1/r3", "body/fence/r1"
    messages = books(
        r1=account(sent={view: 2, fence: 5}),
        r3=account(received={view: 1}),
        world=account(received={fence: 3}),
    )
    assert (messages.sent, messages.received, messages.unaccounted) == (7, 4, 3)


def test_the_books_on_which_most_was_lost_are_named_most_first() -> None:
    links = {f"link/r1/r{robot}": robot for robot in range(2, 30)}
    lost = books(r1=account(sent=links), **{f"r{robot}": account() for robot in range(2, 30)})
    assert lost.unaccounted == sum(range(2, 30))
    assert list(lost.unaccounted_on.items())[:2] == [("link/r1/r29 > r29", 29), ("link/r1/r28 > r28", 28)]
    assert len(lost.unaccounted_on) == 20
    assert (
        books(r1=account(sent={"link/r1/r2": 1}), r2=account(received={"link/r1/r2": 1})).unaccounted_on == {}
    )


def test_what_the_operator_puts_is_in_no_book() -> None:
    stop = "body/fence/0"
    messages = books(world=account(received={stop: 2}, newest={stop: 2}))
    assert (messages.sent, messages.received, messages.left_out) == (0, 0, ())


def test_odometry_sent_after_a_robot_counted_is_in_no_book() -> None:
    odometry = "body/r1/odometry"
    messages = books(
        world=account(sent={odometry: 90}), r1=account(received={odometry: 79}, newest={odometry: 80})
    )
    assert (messages.sent, messages.received, messages.unaccounted) == (80, 79, 1)


def test_books_of_a_dead_robot_are_left_out_and_listed() -> None:
    link, drive = "link/r1/r2", "body/r2/drive"
    messages = balance({"world": account(received={drive: 3}), "r1": account(sent={link: 5})})
    assert (messages.sent, messages.received, messages.unaccounted) == (0, 0, 0)
    assert messages.left_out == ("body/r2/drive > world", "link/r1/r2 > r2")


def test_removed_messages_of_omitted_books_are_counted_separately() -> None:
    link, drive = "link/r1/r2", "body/r1/drive"
    removed = {(link, "r2"): {"drop": 4}, (drive, "world"): {"drop": 1, "corrupt": 2}}
    dead = balance({"world": account(), "r2": account()}, removed=removed)
    assert (dead.injected, dead.injected_left_out) == ({}, {"corrupt": 2, "drop": 5})
    assert dead.left_out == (f"{drive} > world", f"{link} > r2")
    counted = account(newest={link: 4}, injected={"drop": {link: 4}})
    alive = balance({"r1": account(sent={link: 4}), "r2": counted}, removed={(link, "r2"): {"drop": 4}})
    assert (alive.injected, alive.injected_left_out) == ({"drop": 4}, {})


def test_a_message_too_many_on_one_key_does_not_make_up_for_one_that_was_lost_on_another() -> None:
    there, back = "link/r1/r2", "link/r2/r1"
    messages = books(
        r1=account(sent={there: 5}, received={back: 4}), r2=account(sent={back: 3}, received={there: 4})
    )
    assert messages.unaccounted == 1
    assert messages.disagreements == (f"{back} > r1: 4 messages arrived of 3 that were sent",)


def test_what_the_world_never_sent_cannot_arrive() -> None:
    odometry = "body/r1/odometry"
    messages = books(
        world=account(sent={odometry: 3}), r1=account(received={odometry: 4}, newest={odometry: 4})
    )
    assert messages.disagreements == (f"{odometry} > r1: 4 messages arrived of 3 that were sent",)


def test_counts_and_entries_of_faults_are_compared_key_by_key() -> None:
    link = "link/r1/r2"
    accounts = {
        "r1": account(sent={link: 9}),
        "r2": account(
            received={link: 5}, newest={link: 9}, injected={"drop": {link: 3}, "router": {link: 1}}
        ),
    }
    assert balance(accounts, removed={(link, "r2"): {"drop": 3}}).disagreements == ()
    fewer = balance(accounts, removed={(link, "r2"): {"drop": 2}})
    assert fewer.disagreements == (
        f"{link} > r2: drop took away 3 messages by its count and 2 by its entries",
    )
    none = balance({**accounts, "r2": account(received={link: 9})}, removed={(link, "r2"): {"corrupt": 1}})
    told = "corrupt took away 0 messages by its count and 1 by its entries"
    assert none.disagreements == (f"{link} > r2: {told}",)


def test_the_recorders_keys_and_queries_are_in_no_book() -> None:
    keys = {"log/r1": 5, "logged/r1": 5, "body/r1/scan": 5, "mission": 1}
    messages = books(r1=account(sent=keys, received=keys))
    assert (messages.sent, messages.received, messages.left_out) == (0, 0, ())


def test_a_message_removed_by_several_faults_counts_once() -> None:
    tally = Tally()
    for n, (fault, number) in enumerate(
        [("delay", 1), ("corrupt", 2), ("drop", 2), ("drop", 3), ("drop", 0)]
    ):
        injected = FaultInjected(fault=fault, rule=fault, key="link/r1/r2", number=number)
        tally.hear("r2", Entry(n=n, t_s=1.0, hlc="", record=injected))
    assert tally.removed == {("link/r1/r2", "r2"): {"drop": 2}}


def test_counts_that_are_told_in_parts_are_one_account() -> None:
    tally, none = Tally(), dict[str, int]()
    for n, other in enumerate(("r1", "r3"), start=1):
        key = f"view/{other}/r2"
        part = TrafficCounted(
            sent={f"view/r2/{other}": n},
            received={key: n},
            newest={key: n + 1},
            injected={"drop": {key: 1}},
            refused=none,
            overflowed=0,
            unrecorded=n,
        )
        tally.hear("r2", Entry(n=n, t_s=1.0, hlc="", record=part))
    counted = tally.counted[2]
    assert counted.sent == {"view/r2/r1": 1, "view/r2/r3": 2}
    assert counted.newest == {"view/r1/r2": 2, "view/r3/r2": 3}
    assert counted.injected == {"drop": {"view/r1/r2": 1, "view/r3/r2": 1}}
    assert tally.unrecorded_count == 3


def test_a_message_removed_after_its_receiver_has_counted_is_in_no_book() -> None:
    """Odometry arrives, and faults remove it, until the process ends."""
    tally = Tally()
    key = "body/r2/odometry"
    dropped = [FaultInjected(fault="drop", rule="drop", key=key, number=number) for number in (1, 2)]
    none = dict[str, int]()
    counted = TrafficCounted(
        sent=none,
        received=none,
        newest={key: 1},
        injected={"drop": {key: 1}},
        refused=none,
        overflowed=0,
        unrecorded=0,
    )
    records: tuple[Record, ...] = (dropped[0], counted, dropped[1])
    for n, record in enumerate(records, start=1):
        tally.hear("r2", Entry(n=n, t_s=1.0, hlc="", record=record))
    assert tally.removed == {(key, "r2"): {"drop": 1}}
