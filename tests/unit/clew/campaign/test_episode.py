"""An episode: what replays it."""

from clew.campaign.episode import Episode


def test_a_replay_line_quotes_a_path_with_spaces() -> None:
    episode = Episode(
        key="", path="my scenes/one.json", family="", seed=1, robots=2, robots_left_out=0, law=None,
        deployment=None, time_s_max=2.5, widest_path_radius_m=None, wall_s_max=1.0, faults="a b.toml",
    )  # fmt: skip
    assert episode.replay == (
        "./launch/clew rehearse 'my scenes/one.json' -n 2 --time-s-max 2.5 --faults 'a b.toml' --seed 1"
    )
