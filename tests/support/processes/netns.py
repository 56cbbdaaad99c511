"""Two network namespaces joined by a veth pair, for tests of a fleet whose packets are lost.

Rule 1: a namespace lives as long as a process in it, and its keeper ends when the test's end of a pipe
        closes: nothing is left behind, even if the test is killed. No namespace has a name on the machine.
Rule 2: a user namespace gives the rights where the machine lets everybody make one; nothing needs root.
Rule 3: where something is forbidden or not there, `Unavailable` says which command failed, and how.
"""

import contextlib
import subprocess
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from tests.support.deadline import DEADLINE_S

ADDRESS = "10.77.0.1"
"""Of the near end."""
FAR_ADDRESS = "10.77.0.2"


class UnavailableError(Exception):
    """This machine has no such namespaces."""


@dataclass(frozen=True, slots=True)
class Namespace:
    """One of the two, by the process that keeps it."""

    keeper: int

    def command(self, *command: str) -> list[str]:
        """A command line that runs a command in here."""
        enter = ["nsenter", "--target", str(self.keeper), "--user", "--net", "--preserve-credentials", "--"]
        return [*enter, *command]

    def inode(self) -> str:
        """What the kernel calls it."""
        return str(Path(f"/proc/{self.keeper}/ns/net").readlink())

    def run(self, *command: str, told: str = "") -> str:
        """Run a command in here; returns what it says.

        Raises:
            UnavailableError: it failed.
        """
        return _run(self.command(*command), shown=command, told=told)

    def suffer(self, rules: str) -> None:
        """Have these rules of nftables, and no others; `input` and `output` are chains of theirs."""
        self.run("nft", "--file", "-", told=f"flush ruleset\n{rules}")


@dataclass(frozen=True, slots=True)
class Wire:
    """Two namespaces, and the veth pair between them."""

    near: Namespace
    far: Namespace

    def cut(self) -> None:
        """Take the link down."""
        self.near.run("ip", "link", "set", "wire", "down")

    def mend(self) -> None:
        """Take it up again."""
        self.near.run("ip", "link", "set", "wire", "up")


def chains(*, entering: str = "", leaving: str = "") -> str:
    """The rules of a namespace: what happens to packets that enter it, and that leave it."""
    return "".join(
        f"table inet faults {{\nchain {name} {{\ntype filter hook {name} priority 0\n{rule}\n}}\n}}\n"
        for name, rule in (("input", entering), ("output", leaving))
    )


def drop(probability: float) -> str:
    """A rule that drops packets at random."""
    return f"numgen random mod 1000 < {round(1000 * probability)} drop"


@contextlib.contextmanager
def wire() -> Iterator[Wire]:
    """Two namespaces joined by a veth pair.

    Raises:
        UnavailableError: this machine will not have them.
    """
    with contextlib.ExitStack() as stack:
        near = stack.enter_context(_kept(["unshare", "--user", "--map-root-user", "--net"]))
        far = stack.enter_context(_kept(near.command("unshare", "--net")))
        peer = ("peer", "name", "wire", "netns", str(far.keeper))
        near.run("ip", "link", "add", "wire", "type", "veth", *peer)
        for namespace, address in ((near, ADDRESS), (far, FAR_ADDRESS)):
            namespace.run("ip", "address", "add", f"{address}/30", "dev", "wire")
            for device in ("lo", "wire"):
                namespace.run("ip", "link", "set", device, "up")
        far.suffer(chains(entering=drop(0.5)))  # finds out whether nftables is there, and the rights
        far.suffer("")
        yield Wire(near, far)


@contextlib.contextmanager
def _kept(command: Sequence[str]) -> Iterator[Namespace]:
    """A namespace, and the process that keeps it."""
    pipe = subprocess.PIPE
    keeper = [*command, "sh", "-c", "echo kept; exec cat"]
    try:
        process = subprocess.Popen(keeper, stdin=pipe, stdout=pipe, stderr=pipe, text=True)
    except OSError as error:
        raise UnavailableError(f"`{' '.join(command)}`: {error}") from error
    with process:
        try:
            assert process.stdout is not None
            if process.stdout.readline() != "kept\n":
                raise UnavailableError(f"`{' '.join(command)}`: {process.communicate()[1].strip()}")
            yield Namespace(process.pid)
        finally:
            process.kill()


def _run(command: Sequence[str], *, shown: Sequence[str], told: str) -> str:
    done = subprocess.run(
        command, input=told, capture_output=True, text=True, timeout=DEADLINE_S, check=False
    )
    if done.returncode != 0:
        raise UnavailableError(f"`{' '.join(shown)}`: {done.stderr.strip()}")
    return done.stdout


def holders(inode: str) -> list[int]:
    """The processes in a network namespace."""
    found = []
    for entry in Path("/proc").iterdir():
        with contextlib.suppress(OSError):  # it has just ended, or is not ours
            if entry.name.isdigit() and str((entry / "ns" / "net").readlink()) == inode:
                found.append(int(entry.name))
    return found
