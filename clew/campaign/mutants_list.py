"""The mutants of our source. Each breaks one rule on which safety or healing depends."""

from dataclasses import dataclass

SEEDS_MAX = 300


@dataclass(frozen=True, slots=True)
class Edit:
    """A piece of source and its replacement."""

    file: str
    before: str
    after: str


@dataclass(frozen=True, slots=True)
class Mutant:
    """Our source with one rule broken."""

    name: str
    rule: str
    """The rule that it breaks."""
    edits: tuple[Edit, ...]
    seeds_max: int = SEEDS_MAX


def _mutant(name: str, rule: str, file: str, before: str, after: str) -> Mutant:
    return Mutant(name, rule, (Edit(file, before, after),))


MUTANTS = (
    Mutant(
        "no-separation",
        "a grant ends at least `keep` before the ground that its granter may occupy",
        (
            Edit("agents/strand/grants.py", "progress_m - self.keep_m + THERE_M)", "progress_m)"),
            Edit("agents/strand/grants.py", "keep_m=self.keep_m)", "keep_m=0.0)"),
        ),
    ),
    _mutant(
        "path-is-authority",
        "a robot drives only as far as its authority, even where it knows more of the path",
        "agents/strand/strand.py",
        "self.authority_m = max(self.authority_m, state.authority_m)",
        "self.authority_m = self.path.end_m",
    ),
    _mutant(
        "grant-survives-turn",
        "the grants of an epoch are void in the next one",
        "agents/strand/strand.py",
        "        turned.own_leg_m = at.own_m  #",
        "        turned.authority_m = self.authority_m\n        turned.own_leg_m = at.own_m  #",
    ),
    _mutant(
        "hairpins",
        "grants keep distance in the plane, not only along the path",
        "protocol/wire/authority.py",
        "    ground = path.corners(progress_m, path.end_m)\n",
        "    return max(from_m, progress_m - keep_m)\n    ground = path.corners(progress_m, path.end_m)\n",
    ),
    _mutant(
        "leader-over-grants",
        "the leader's next step stays clear of all granted ground",
        "agents/navigation/certificate.py",
        "np.full(len(corners) - 1, keep_m)",
        "np.full(len(corners) - 1, 0.0 * keep_m)",
    ),
    _mutant(
        "no-epoch-in-links",
        "a link state of another epoch is void",
        "agents/strand/strand.py",
        "if link.neighbour == heard.robot and heard.state.epoch == self.epoch:",
        "if link.neighbour == heard.robot:",
    ),
    _mutant(
        "older-muster-wins",
        "of two calls, the one with the higher epoch wins",
        "agents/robot.py",
        "        newest = epoch > self.epoch and epoch == self._calls.newest",
        "        newest = epoch != self.epoch",
    ),
    _mutant(
        "no-settling",
        "no robot drives in a new epoch before the robots left out must have stopped",
        "agents/membership/calls.py",
        "lining.settled_at_s = self.free_at_s(lining.members, now_s)",
        "lining.settled_at_s = now_s",
    ),
    _mutant(
        "turns-not-ended",
        "the next turn is given only after the last one has ended",
        "agents/membership/giving.py",
        "            if theirs is None or theirs.ended < given.number:",
        "            if theirs is None:",
    ),
    _mutant(
        "no-dead-man",
        "a body stops when its robot sends no orders",
        "world/bodies/bodies.py",
        "(now_s - self._basis_s > DEADMAN_S + ROUNDING_S)",
        "(now_s - self._basis_s > 1e9)",
    ),
    _mutant(
        "numbers-again",
        "the orders of a restarted robot have higher numbers than those of its former life",
        "agents/body/driver.py",
        "        number = max(self.odometry.ordered, int(self.odometry.t_s * NUMBERS_PER_S)) + LATE_ORDERS\n",
        "        number = 0\n",
    ),
    _mutant(
        "binds-moving",
        "a member reports that it is bound only when it stands still",
        "agents/membership/lining.py",
        "        if not announcer.has_spoken and not driver.standing:",
        "        if False:",
    ),
    Mutant(
        "ghost",
        "a robot that has left a strand neither drives nor sends messages in it",
        (
            Edit(
                "agents/robot.py",
                "        self._member = None\n        self._driver.begin(0.0)\n",
                "        self._ghost, self._member = self._member, None\n",
            ),
            Edit(
                "agents/robot.py",
                "        commands = lining.act(self._driver, scan, now_s)\n",
                "        commands = lining.act(self._driver, scan, now_s)\n"
                '        if (ghost := getattr(self, "_ghost", None)) is not None:\n'
                "            commands += ghost.act(now_s)\n",
            ),
        ),
    ),
    _mutant(
        "no-majority",
        "robots are left out only if the rest are a majority, both at the call and afterwards",
        "agents/membership/calls.py",
        "    return 2 * len(members) > len(shown)\n",
        "    return bool(members) and bool(shown)\n",
    ),
    _mutant(
        "no-checksum",
        "a damaged message is refused",
        "protocol/wire/codec.py",
        "    if _seal(content, key) != payload[-SEAL_BYTES:]:",
        "    if len(payload) < SEAL_BYTES:",
    ),
    _mutant(
        "no-epsilon",
        "steps and segments keep epsilon from obstacles",
        "protocol/mission.py",
        "        return self.robot_radius_m + max(self.clear_m, ",
        "        return self.robot_radius_m + max(0.0, ",
    ),
    _mutant(
        "grants-to-the-tail",
        "a robot grants ground to the robot directly behind it",
        "agents/strand/strand.py",
        "commands.append(Tell(self.behind.neighbour, ",
        "commands.append(Tell(self.order[-1], ",
    ),
    Mutant(
        "late-orders",
        "a body refuses an order that is older, by epoch or by number, than one that it has accepted",
        (
            Edit(
                "world/bodies/bodies.py",
                "if drive.target is not None and drive.epoch < epoch:",
                "if drive.target is not None and drive.epoch < 0:",
            ),
            Edit(
                "world/bodies/bodies.py",
                "        if drive.number < self.ordered(body) or drive.basis_s < self._basis_s[body]:",
                "        if False:",
            ),
        ),
    ),
    Mutant(
        "dead-man-by-arrival",
        "an order expires a fixed time after the odometry that it is based on, not after its arrival",
        (
            Edit(
                "world/bodies/bodies.py",
                "if not now_s - DEADMAN_S - ROUNDING_S <= drive.basis_s <= now_s + ROUNDING_S:",
                "if drive.basis_s > now_s + ROUNDING_S:",
            ),
            Edit(
                "world/bodies/bodies.py",
                "        self._basis_s[body], self._until_s[body] = drive.basis_s, until_s",
                "        self._basis_s[body], self._until_s[body] = now_s, until_s",
            ),
        ),
    ),
    Mutant(
        "unchecked-legs",
        "a follower checks its own leg and each segment against its own scans",
        (
            Edit(
                "agents/strand/advance.py",
                "        if self._needs_check(strand, reach_m):",
                "        if False:",
            ),
            Edit(
                "agents/membership/lining.py",
                "say(leg_clear=leg_is_clear(self.look, ahead, self._mission))",
                "say(leg_clear=True)",
            ),
        ),
    ),
    _mutant(
        "silence-unnoticed",
        "a link that is silent for too long is broken",
        "protocol/wire/link.py",
        "        return now_s - max(self._echoed_s, self.made_at_s)",
        "        return 0.0",
    ),
    _mutant(
        "acknowledges-unheard",
        "the robot behind acknowledges only the vertices that it knows",
        "agents/strand/strand.py",
        "            handed=own.handed.number,\n            vertices=len(self.path),\n",
        "            handed=own.handed.number,\n            vertices=len(self.path) + 2,\n",
    ),
    _mutant(
        "tokens-come-back",
        "members go on only while they may leave out all other robots that show a token",
        "agents/robot.py",
        "if not members or self._calls.may_go_on(members, now_s):",
        "if True:",
    ),
    _mutant(
        "number-one-again",
        "a restarted robot's order numbers are higher even if its body accepted no order of the former life",
        "agents/body/driver.py",
        "        number = max(self.odometry.ordered, int(self.odometry.t_s * NUMBERS_PER_S)) + LATE_ORDERS\n",
        "        number = self.odometry.ordered + (LATE_ORDERS if self.odometry.ordered else 0)\n",
    ),
)
