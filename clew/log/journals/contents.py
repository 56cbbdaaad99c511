"""What a message says, in short: a few words for people."""

from typing import assert_never

from agents.commands import AskScan, Command, Note, Order, Put, Say, Tell
from protocol.fence import Epoch, Fence, Raise, Turn
from protocol.frames import Point, Pose
from protocol.keys import robot_name
from protocol.timeline import kind_of
from protocol.timeline.sentences import CAUSES, sentence
from protocol.wire.messages import AheadState, BehindState, Drive, Message, Odometry, Scan, ScanQuery
from protocol.wire.view import Answer, Formation, Plea, Report


def content(message: Message) -> str:
    """The content of a message in a few words."""
    return ", ".join(part for part in _parts(message) if part)


def does(robot: int, command: Command) -> str:
    """What a command of a robot does."""
    match command:
        case Note(record):
            return f"notes {kind_of(record)}: {sentence(robot_name(robot), record)}"
        case AskScan(revolutions):
            return f"asks for a scan of {revolutions} revolutions"
        case Say(other, message) | Tell(other, message):
            return f"tells {robot_name(other)}, {tag_of(message)}: {content(message)}"
        case Put(change):
            return f"puts {tag_of(change)}: {content(change)}"
        case Order(drive):
            return f"orders its body, {content(drive)}"
        case _:
            assert_never(command)


def tag_of(message: Message) -> str:
    """The kind of a message, as in fault plans."""
    return str(message.__struct_config__.tag)


def _parts(message: Message) -> tuple[str, ...]:
    match message:
        case AheadState() | BehindState():
            return _of_link(message)
        case Report() | Answer() | Formation() | Plea():
            return _of_view(message)
        case Odometry():
            return (
                f"at {_at(message.pose)}",
                "moves" if message.moving else "stands",
                f"order {message.finished} finished",
                _fence(message.fence),
            )
        case Scan(ranges_m=ranges_m):
            return f"{len(ranges_m)} rays", f"nearest {min(ranges_m):.2f} m", f"from {_at(message.pose)}"
        case _:
            return _of_order(message)


def _of_order(message: Message) -> tuple[str, ...]:
    match message:
        case Drive(number=number, target=target):
            return f"order {number}", "stand still" if target is None else f"drive to {_at(target)}"
        case Raise(epoch=epoch, cause=cause):
            return f"propose view {epoch.number}", CAUSES[cause]
        case Turn(fence=fence):
            return (_fence(fence),)
        case ScanQuery(revolutions=revolutions):
            return (f"{revolutions} revolutions",)
        case _:
            return ()  # a mission, or of the recorder


def _of_link(state: AheadState | BehindState) -> tuple[str, ...]:
    at = f"at {state.progress_m:.2f} m"
    match state:
        case AheadState():
            return (
                at,
                f"grants {state.authority_m:.2f} m",
                f"corners {_range(state.path_from, len(state.path), state.vertices)}" if state.path else "",
                "has arrived" if state.arrived else "",
                "backs up" if state.backs_up else "",
                "" if state.handed is None else f"hands over map {state.handed.number}",
            )
        case BehindState():
            stands = "all behind it stand" if state.stand else "not all behind it stand"
            return at, f"tail at {state.tail_progress_m:.2f} m", f"has {state.vertices} corners", stands
        case _:
            assert_never(state)


def _of_view(said: Report | Answer | Formation | Plea) -> tuple[str, ...]:
    epoch = _epoch(said.epoch)
    match said:
        case Report():
            look = "" if said.look is None else f"answers question {said.look.number}"
            return f"report {said.number}", epoch, f"at {_at(said.place)}", look
        case Answer():
            return (
                f"to report {said.heard}" if said.heard else "to a plea",
                epoch,
                "left out" if said.out else "",
                "" if said.question is None else f"asks question {said.question.number}",
                "" if said.join is None else f"join in turn {said.join.turn}",
                "" if said.rank is None else f"rank {said.rank}",
            )
        case Formation():
            corners = _range(said.first, len(said.path), said.vertices)
            return epoch, f"rank {said.rank} of {said.members}", f"at {said.s_m:.2f} m", f"corners {corners}"
        case Plea():
            return epoch, "asks to be let in"
        case _:
            assert_never(said)


def _at(place: Point | Pose) -> str:
    return f"({place.x_m:.2f}, {place.y_m:.2f})"


def _epoch(epoch: Epoch) -> str:
    return f"epoch {epoch.number}"


def _fence(fence: Fence) -> str:
    who = f" r{fence.robot}" if fence.may == "one" else ""
    return f"fence {fence.epoch.number}/{fence.turn} {fence.may}{who}"


def _range(first: int, count: int, whole: int) -> str:
    """Which of the corners of a path, counted from 1."""
    return f"{first + 1} to {first + count} of {whole}"
