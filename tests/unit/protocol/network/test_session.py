"""Sessions: the identity of a process on the network, readable only by its owner."""

import stat
from pathlib import Path
from typing import Any

import pytest

from protocol.errors import UsageError
from protocol.keys import Keys
from protocol.network.session import (
    Crew,
    Session,
    check_endpoint,
    read_router_session,
    read_session,
    unix_socket_endpoint,
    write_all_sessions,
    write_sessions,
)
from protocol.network.settings import client_settings, router_settings

ENDPOINT = "unixsock-stream//tmp/x/router.sock"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    folder = tmp_path / "run" / "net"
    write_sessions(folder, fleet="f", run="t1", robots=3, endpoints=[ENDPOINT])
    return folder


def passwords(folder: Path) -> dict[str, str]:
    return dict(line.split(":") for line in (folder / "users").read_text().splitlines())


def test_every_process_of_the_run_gets_its_own_session(folder: Path) -> None:
    known = passwords(folder)
    assert sorted(known) == ["f.r1", "f.r2", "f.r3", "f.world"]
    for user, password in known.items():
        name = user.removeprefix("f.")
        assert read_session(folder / f"{name}.json") == Session(
            fleet="f", run="t1", name=name, robots=3, endpoints=(ENDPOINT,), user=user, password=password
        )


def test_the_processes_of_several_fleets_have_keys_and_passwords_of_their_own(tmp_path: Path) -> None:
    crews = [
        Crew(fleet=name, robots=robots, sessions=tmp_path / name) for name, robots in (("a", 1), ("b", 2))
    ]
    write_all_sessions(tmp_path, crews, run="t1", endpoints=[ENDPOINT])
    one, other = (read_session(tmp_path / name / "r1.json") for name in ("a", "b"))
    assert (one.keys, other.keys) == (Keys("a", "t1"), Keys("b", "t1"))
    assert one.password != other.password
    assert one.robots == 3  # for time limits: they share the router
    assert len(passwords(tmp_path)) == 5
    assert read_router_session(tmp_path).fleet_keys == {one.keys: 1, other.keys: 2}


def test_the_routers_session_contains_its_users_and_endpoints(folder: Path) -> None:
    session = read_router_session(folder)
    assert (session.fleet_keys, session.endpoints) == ({Keys("f", "t1"): 3}, (ENDPOINT,))
    settings = router_settings(session, folder)
    assert settings["transport"]["auth"]["usrpwd"] == {"dictionary_file": str(folder / "users")}


def test_no_two_processes_and_no_two_runs_share_a_password(folder: Path, tmp_path: Path) -> None:
    write_sessions(tmp_path / "other", fleet="f", run="t1", robots=3, endpoints=[ENDPOINT])
    all_passwords = [*passwords(folder).values(), *passwords(tmp_path / "other").values()]
    assert len(set(all_passwords)) == 8
    assert min(len(password) for password in all_passwords) >= 32


def test_only_the_owner_can_read_the_folder_and_its_files(folder: Path) -> None:
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    assert {stat.S_IMODE(file.stat().st_mode) for file in folder.iterdir()} == {0o600}


def test_files_that_were_readable_by_others_are_protected(tmp_path: Path) -> None:
    (tmp_path / "r1.json").touch(mode=0o666)
    tmp_path.chmod(0o777)
    write_sessions(tmp_path, fleet="f", run="t1", robots=1, endpoints=[ENDPOINT])
    assert stat.S_IMODE(tmp_path.stat().st_mode) == 0o700
    assert stat.S_IMODE((tmp_path / "r1.json").stat().st_mode) == 0o600


def test_sessions_for_a_user_owned_router_have_no_passwords(tmp_path: Path) -> None:
    folder = tmp_path / "net"
    write_sessions(folder, fleet="f", run="t1", robots=1, endpoints=["tcp/127.0.0.1:7447"], passwords=False)
    assert sorted(file.name for file in folder.iterdir()) == ["r1.json", "world.json"]
    session = read_session(folder / "r1.json")
    assert session.password is None
    assert "auth" not in client_settings(session)["transport"]


@pytest.mark.parametrize(
    "wrong",
    [
        {"fleet": "a/b"},
        {"fleet": "*"},
        {"run": ""},
        {"run": "$*"},
        {"run": "x\n"},
        {"robots": 0},
        {"endpoints": ["nowhere"]},
        {"endpoints": ["unixsock-stream/" + "/x" * 100]},
        {"endpoints": []},
        {"endpoints": [ENDPOINT] * 3},
    ],
)
def test_invalid_names_and_endpoints_are_refused_and_no_file_is_created(
    tmp_path: Path, wrong: dict[str, Any]
) -> None:
    right: dict[str, Any] = {"fleet": "f", "run": "t1", "robots": 1, "endpoints": [ENDPOINT]}
    with pytest.raises(UsageError):
        write_sessions(tmp_path / "net", **(right | wrong))
    assert not (tmp_path / "net").exists()


def test_a_folder_that_cannot_be_created_is_a_usage_error(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(UsageError, match="cannot write sessions"):
        write_sessions(tmp_path / "file" / "net", fleet="f", run="t1", robots=1, endpoints=[ENDPOINT])


@pytest.mark.parametrize("content", [None, b"", b"{}", b"\xff", b'{"fleet": "*"}', b"[" * 5000])
def test_a_file_without_a_session_is_a_usage_error_in_one_line(tmp_path: Path, content: bytes | None) -> None:
    path = tmp_path / "r1.json"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(UsageError, match="no session in") as refusal:
        read_session(path)
    assert "\n" not in str(refusal.value)


def test_a_socket_path_may_have_the_maximum_length_of_the_kernel_and_no_more() -> None:
    longest = "unixsock-stream//" + "x" * 106
    check_endpoint(longest)
    with pytest.raises(UsageError, match="107 bytes, not 108"):
        check_endpoint(longest + "x")


TLS = "tls/127.0.0.1:7447#listen_private_key_file={file}"


def test_an_endpoint_may_name_files_and_what_zenoh_knows(tmp_path: Path) -> None:
    file = tmp_path / "router.key"
    file.touch()
    check_endpoint(TLS.format(file=file) + ";enable_mtls=true;verify_name_on_connect=false;iface=lo")
    check_endpoint(f"quic/127.0.0.1:7447#root_ca_certificate_file={file};new_in_zenoh=1")
    check_endpoint("tcp/127.0.0.1:7447#so_sndbuf=65536")


@pytest.mark.parametrize(
    ("endpoint", "said"),
    [
        (TLS.format(file="nope.key"), "listen_private_key_file=nope.key: No such file or directory"),
        (TLS.format(file="."), "listen_private_key_file=.: Is a directory"),
        (TLS.format(file=""), "listen_private_key_file=: "),
        (TLS.format(file="/dev/null,enable_mtls=true"), "No such file or directory|Not a directory"),
        (TLS.format(file="k" * 1000), "may have 1000 characters, not "),
        (
            "tls/127.0.0.1:7447#enable_mtsl=true",
            "tls/127.0.0.1:7447 has no setting 'enable_mtsl'; did you mean 'enable_mtls'",
        ),
        (
            "tcp/127.0.0.1:7447#root_ca_certificate_file=/dev/null",
            "root_ca_certificate_file is a setting of tls/, and tcp/127.0.0.1:7447 is not encrypted",
        ),
    ],
)
def test_a_setting_that_would_protect_nothing_is_refused(endpoint: str, said: str) -> None:
    with pytest.raises(UsageError, match=said):
        check_endpoint(endpoint)


def test_the_default_socket_is_in_the_runs_own_folder(tmp_path: Path) -> None:
    assert unix_socket_endpoint(tmp_path) == f"unixsock-stream/{tmp_path}/router.sock"


def test_no_process_uses_scouting_shared_memory_or_a_second_link(folder: Path) -> None:
    client = client_settings(read_session(folder / "r1.json"))
    for settings in (client, router_settings(read_router_session(folder), folder)):
        assert settings["scouting"]["multicast"] == settings["scouting"]["gossip"] == {"enabled": False}
        assert settings["transport"]["shared_memory"] == {"enabled": False}
        assert settings["transport"]["unicast"]["max_links"] == 1
    assert client["listen"] == {"endpoints": []}
    assert client["connect"]["endpoints"] == [ENDPOINT]


def test_of_two_routers_the_second_connects_to_the_first_and_knows_it_by_the_id_of_this_run(
    tmp_path: Path,
) -> None:
    endpoints = [unix_socket_endpoint(tmp_path, number) for number in (1, 2)]
    known: set[str | None] = set()
    for name in ("a", "b"):
        folder = tmp_path / name
        write_sessions(folder, fleet="f", run="t1", robots=1, endpoints=endpoints)
        session = read_router_session(folder)
        first, second = (router_settings(session, folder, number) for number in (1, 2))
        assert (first["connect"]["endpoints"], second["connect"]["endpoints"]) == ([], endpoints[:1])
        assert (first["id"], second.get("id")) == (session.first, None)
        assert first["access_control"]["subjects"][-1] == {"id": "router", "usernames": ["router"]}
        assert second["access_control"]["subjects"][-1] == {"id": "router", "zids": [session.first]}
        assert second["transport"]["auth"]["usrpwd"]["password"] == passwords(folder)["router"]
        known.add(session.first)
    assert len(known) == 2
    assert read_router_session(folder).endpoints == tuple(endpoints)


@pytest.mark.parametrize(
    ("endpoint", "password", "said"),
    [
        ("tcp/a:1", "x", "no router answers at tcp/a:1, or it refuses the password of r1"),
        (
            "tcp/a:1",
            None,
            "no router answers at tcp/a:1, or it wants a password: there is none with --connect",
        ),
        (
            "tls/a:1#root_ca_certificate_file=/ca.pem",
            "x",
            "no router answers at tls/a:1, or it refuses the password of r1, or a certificate is refused "
            "(expired, of another address, or of another root)",
        ),
    ],
)
def test_a_session_without_a_link_says_only_what_can_be_the_reason(
    endpoint: str, password: str | None, said: str
) -> None:
    session = Session(fleet="f", run="r", name="r1", endpoints=(endpoint,), password=password)
    assert session.no_link == said
