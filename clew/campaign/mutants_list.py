"""The bugs that the oracle check plants: each breaks one rule on which safety or healing rests."""

from dataclasses import dataclass

SEEDS_MAX = 300


@dataclass(frozen=True, slots=True)
class Edit:
    """A piece of source, and what stands there instead."""

    file: str
    before: str
    after: str


@dataclass(frozen=True, slots=True)
class Bug:
    """One rule broken."""

    name: str
    rule: str
    """What holds without it."""
    edits: tuple[Edit, ...]
    seeds_max: int = SEEDS_MAX


def _bug(name: str, rule: str, file: str, before: str, after: str) -> Bug:
    return Bug(name, rule, (Edit(file, before, after),))


BUGS = (
    Bug(
        "no-separation",
        "authority ends `keep` short of its granter's ground",
        (
            Edit("agents/strand/grants.py", "progress_m - self.keep_m + THERE_M)", "progress_m)"),
            Edit("agents/strand/grants.py", "keep_m=self.keep_m)", "keep_m=0.0)"),
        ),
    ),
    _bug(
        "path-is-authority",
        "a robot drives to its authority, not to the end of the path that it knows",
        "agents/strand/strand.py",
        "self.authority_m = max(self.authority_m, state.authority_m)",
        "self.authority_m = self.path.end_m",
    ),
    _bug(
        "grant-survives-turn",
        "in the next epoch no grant of the old one is valid",
        "agents/strand/strand.py",
        "        turned.own_leg_m = at.own_m  #",
        "        turned.authority_m = self.authority_m\n        turned.own_leg_m = at.own_m  #",
    ),
    _bug(
        "hairpins",
        "authority asks for distance in the plane, not along the path alone",
        "protocol/wire/authority.py",
        "    ground = path.corners(progress_m, path.end_m)\n",
        "    return max(from_m, progress_m - keep_m)\n    ground = path.corners(progress_m, path.end_m)\n",
    ),
    _bug(
        "leader-over-grants",
        "the leader's next step keeps off all ground that has been granted",
        "agents/navigation/certificate.py",
        "np.full(len(corners) - 1, keep_m)",
        "np.full(len(corners) - 1, 0.0 * keep_m)",
    ),
    _bug(
        "no-epoch-in-links",
        "a link state of another epoch is void",
        "agents/strand/strand.py",
        "if link.neighbour == heard.robot and heard.state.epoch == self.epoch:",
        "if link.neighbour == heard.robot:",
    ),
    _bug(
        "older-muster-wins",
        "of two calls the higher wins",
        "agents/robot.py",
        "        newest = epoch > self.epoch and epoch == self._calls.newest",
        "        newest = epoch != self.epoch",
    ),
    _bug(
        "no-settling",
        "nobody drives in a new epoch before those left out must stand",
        "agents/membership/calls.py",
        "lining.settled_at_s = self.free_at_s(lining.members, now_s)",
        "lining.settled_at_s = now_s",
    ),
    _bug(
        "turns-not-ended",
        "the next turn is given when the last has ended",
        "agents/membership/giving.py",
        "            if theirs is None or theirs.ended < given.number:",
        "            if theirs is None:",
    ),
    _bug(
        "no-dead-man",
        "a body stands whose robot says nothing",
        "world/bodies/bodies.py",
        "(now_s - self._basis_s > DEADMAN_S + ROUNDING_S)",
        "(now_s - self._basis_s > 1e9)",
    ),
    _bug(
        "numbers-again",
        "a restarted robot numbers its orders beyond those of its forerunner",
        "agents/body/driver.py",
        "        number = max(self.odometry.ordered, int(self.odometry.t_s * NUMBERS_PER_S)) + LATE_ORDERS\n",
        "        number = 0\n",
    ),
    _bug(
        "binds-moving",
        "a member says that it is bound only when it stands",
        "agents/membership/lining.py",
        "        if not announcer.has_spoken and not driver.standing:",
        "        if False:",
    ),
    Bug(
        "ghost",
        "who has left a strand neither drives nor speaks in it any more",
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
    _bug(
        "no-majority",
        "robots are left out only where the rest are more than half, when they are called and afterwards",
        "agents/membership/calls.py",
        "    return 2 * len(members) > len(shown)\n",
        "    return bool(members) and bool(shown)\n",
    ),
    _bug(
        "no-checksum",
        "a damaged message is refused",
        "protocol/wire/codec.py",
        "    if _seal(content, key) != payload[-SEAL_BYTES:]:",
        "    if len(payload) < SEAL_BYTES:",
    ),
    _bug(
        "no-epsilon",
        "steps and segments keep epsilon from obstacles",
        "protocol/mission.py",
        "        return self.robot_radius_m + max(self.clear_m, ",
        "        return self.robot_radius_m + max(0.0, ",
    ),
    _bug(
        "grants-to-the-tail",
        "a robot grants ground to the one right behind it",
        "agents/strand/strand.py",
        "commands.append(Tell(self.behind.neighbour, ",
        "commands.append(Tell(self.order[-1], ",
    ),
    Bug(
        "late-orders",
        "a body takes no order that is older than one that it has taken, by epoch or by number",
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
    Bug(
        "dead-man-by-arrival",
        "an order is good for a time from the odometry that it was given on, however late it came",
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
    Bug(
        "unchecked-legs",
        "who follows checks its own leg, and each segment, against its own scans",
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
    _bug(
        "silence-unnoticed",
        "a link that is silent for long is given up",
        "protocol/wire/link.py",
        "        return now_s - max(self._echoed_s, self.made_at_s)",
        "        return 0.0",
    ),
    _bug(
        "acknowledges-unheard",
        "who is behind acknowledges the vertices that it knows, and no others",
        "agents/strand/strand.py",
        "            handed=own.handed.number,\n            vertices=len(self.path),\n",
        "            handed=own.handed.number,\n            vertices=len(self.path) + 2,\n",
    ),
    _bug(
        "tokens-come-back",
        "members go on only as long as they may leave out whoever shows a token",
        "agents/robot.py",
        "if not members or self._calls.may_go_on(members, now_s):",
        "if True:",
    ),
    _bug(
        "number-one-again",
        "a restarted robot's orders are beyond its forerunner's also where its body has taken none of those",
        "agents/body/driver.py",
        "        number = max(self.odometry.ordered, int(self.odometry.t_s * NUMBERS_PER_S)) + LATE_ORDERS\n",
        "        number = self.odometry.ordered + (LATE_ORDERS if self.odometry.ordered else 0)\n",
    ),
)
