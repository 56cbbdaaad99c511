"""Two network namespaces joined by a veth pair, for tests of a fleet whose packets are lost.

Rule 1: a namespace lives as long as a process in it. Its keeper ends when the test's end of a pipe closes, so
        nothing is left behind, even if the test is killed. No namespace has a name on the machine.
Rule 2: nothing needs root: a user namespace gives the rights, if the machine lets users make one.
Rule 3: if something is forbidden or missing, `UnavailableError` names the failed command and its error.
"""

import contextlib
import subprocess
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from tests.support.deadline import DEADLINE_S

ADDRESS = "10.77.0.1"
"""The address of the near end."""
FAR_ADDRESS = "10.77.0.2"


class UnavailableError(Exception):
    """This machine offers no such namespaces."""


@dataclass(frozen=True, slots=True)
class Namespace:
    """One of the two namespaces, identified by its keeper process."""

    keeper: int

    def command(self, *command: str) -> list[str]:
        """A command line that runs a command in this namespace."""
        enter = ["nsenter", "--target", str(self.keeper), "--user", "--net", "--preserve-credentials", "--"]
        return [*enter, *command]

    def inode(self) -> str:
        """The kernel's name for it."""
        return str(Path(f"/proc/{self.keeper}/ns/net").readlink())

    def run(self, *command: str, told: str = "") -> str:
        """Run a command in this namespace; returns its output.

        Raises:
            UnavailableError: it failed.
        """
        return _run(self.command(*command), shown=command, told=told)

    def suffer(self, rules: str) -> None:
        """Replace all nftables rules by these; `input` and `output` are their chains."""
        self.run("nft", "--file", "-", told=f"flush ruleset\n{rules}")


@dataclass(frozen=True, slots=True)
class Wire:
    """Two namespaces and the veth pair between them."""

    near: Namespace
    far: Namespace

    def cut(self) -> None:
        """Take the link down."""
        self.near.run("ip", "link", "set", "wire", "down")

    def mend(self) -> None:
        """Take it up again."""
        self.near.run("ip", "link", "set", "wire", "up")


def chains(*, entering: str = "", leaving: str = "") -> str:
    """The rules of a namespace for packets that enter it and packets that leave it."""
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
        UnavailableError: this machine does not allow them.
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
        far.suffer(chains(entering=drop(0.5)))  # checks that nftables and the rights exist
        far.suffer("")
        yield Wire(near, far)


@contextlib.contextmanager
def _kept(command: Sequence[str]) -> Iterator[Namespace]:
    """A namespace and its keeper process."""
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
        with contextlib.suppress(OSError):  # it has just ended or belongs to another user
            if entry.name.isdigit() and str((entry / "ns" / "net").readlink()) == inode:
                found.append(int(entry.name))
    return found
