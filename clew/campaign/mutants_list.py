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
        "any-fence",
        "F1: a body obeys an order only if it bears exactly its fence",
        "protocol/fence.py",
        "    exactly = (bearing.epoch, bearing.turn) == (fence.epoch, fence.turn)\n",
        "    exactly = True\n",
    ),
    _mutant(
        "drives-on",
        "F1: when the fence changes, all bodies stop and drop their orders",
        "world/bodies/arena.py",
        "        self.bodies.stand()\n        return [*samples, ",
        "        return [*samples, ",
    ),
    _mutant(
        "turn-of-all",
        "F3: in a turn, one robot may move",
        "protocol/fence.py",
        "        one = self.may is May.ONE and (self.robot, self.life) == (robot, life)\n",
        "        one = self.may is May.ONE\n",
    ),
    Mutant(
        "orders-untold",
        "F2: a robot orders motion only under the fence that its odometry tells",
        (
            Edit(
                "agents/body/driver.py",
                "return self._odometry is not None and self._is_told(self._bearing) and",
                "return self._odometry is not None and",
            ),
            Edit(
                "protocol/fence.py",
                "    exactly = (bearing.epoch, bearing.turn) == (fence.epoch, fence.turn)\n",
                "    exactly = True\n",
            ),
            Edit(
                "agents/body/driver.py",
                "        return not self._is_told(self._drive.bearing)\n",
                "        return False\n",
            ),
        ),
    ),
    _mutant(
        "any-life-coordinates",
        "F3, F4: only the life that proposed a view coordinates it",
        "agents/membership/membership.py",
        "        if (epoch.robot, epoch.life) == (self._robot, self._life):\n",
        "        if epoch.robot == self._robot:\n",
    ),
    _mutant(
        "fence-unwritten",
        "a change of the fence is in the timeline before it takes effect",
        "world/bodies/arena.py",
        "self.note(taken.as_record())]",
        "*([self.note(taken.as_record())] if taken.cause else self.sample())]",
    ),
    _mutant(
        "old-places",
        "F4: a place in the formation is read after the last turn of its robot",
        "agents/coordinating/reported.py",
        " if self.counted[robot].turn <= turns.put_for(robot) > 0}\n",
        " if False}\n",
    ),
    Mutant(
        "acts-before-all",
        "F4, F5: nobody acts on a formation before its ALL",
        (
            Edit(
                "agents/membership/membership.py",
                "        if self.state is State.BOUND and self._fence.may is May.ALL:\n",
                "        if self.state is State.BOUND:\n",
            ),
            Edit(
                "agents/membership/membership.py",
                "whole[0].turn != self._fence.turn or ",
                "",
            ),
            Edit(
                "protocol/fence.py",
                "    return exactly and fence.names(robot, bearing.life)\n",
                "    return exactly\n",
            ),
        ),
    ),
    _mutant(
        "no-epoch-in-links",
        "F5: a link state of another epoch, or of another life, is void",
        "protocol/wire/link.py",
        "        return (robot, state.life, state.epoch) == (self.neighbour, self.life, self.epoch)\n",
        "        return robot == self.neighbour\n",
    ),
    _mutant(
        "old-scans",
        "F6: a scan serves only under the very fence that it bears",
        "agents/body/senses.py",
        "        return scan.fence == fence and in_force(fence)\n",
        "        return in_force(fence)\n",
    ),
    _mutant(
        "hulls-are-members",
        "F6: hits are robots of the strand only where a neighbour may be",
        "agents/strand/strand.py",
        "            grounds.append(self.path.between(self._ahead_m, ahead_until_m))\n",
        "            grounds.append(self.path.between(0.0, self.path.end_m))\n",
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
    _mutant(
        "late-orders",
        "a body refuses an order that is older, by number, than one that it has accepted",
        "world/bodies/bodies.py",
        "        if drive.number < self.ordered[body] or drive.basis_s < self._basis_s[body]:\n",
        "        if False:\n",
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
                "        return not watched and not self._follower.is_clear(reach_m)\n",
                "        return False\n",
            ),
            Edit(
                "agents/membership/reporting.py",
                "        clear = leg_is_clear(seen, xy(question.place), self.mission)\n",
                "        clear = True\n",
            ),
        ),
    ),
    _mutant(
        "silence-unnoticed",
        "a link that is silent for too long is broken",
        "protocol/wire/link.py",
        "        return max(0.0, now_s - max(self.heard_at_s, self.made_at_s))\n",
        "        return 0.0\n",
    ),
    _mutant(
        "acknowledges-unheard",
        "the robot behind acknowledges only the vertices that it knows",
        "agents/strand/strand.py",
        "            handed=own.handed.number,\n            vertices=len(self.path),\n",
        "            handed=own.handed.number,\n            vertices=len(self.path) + 2,\n",
    ),
    _mutant(
        "number-one-again",
        "a restarted robot's order numbers are higher even if its body accepted no order of the former life",
        "agents/body/driver.py",
        "        number = max(self.odometry.ordered, int(self.odometry.t_s * NUMBERS_PER_S)) + LATE_ORDERS\n",
        "        number = self.odometry.ordered + (LATE_ORDERS if self.odometry.ordered else 0)\n",
    ),
    _mutant(
        "promises-more",
        "S4: a step keeps the clearance that it promised; here it promises 30 mm more",
        "agents/navigation/certificate.py",
        "    return max(0.0, float((apart - margin).min()) - mission.robot_radius_m)\n",
        "    return max(0.0, float((apart - margin).min()) - mission.robot_radius_m) + 0.03\n",
    ),
    _mutant(
        "keep-without-mu0",
        "A2: two robots keep the separation and the tolerance, since both may be off their path",
        "protocol/mission.py",
        "        return 2.0 * self.robot_radius_m + self.separation_m + self.mu0_m\n",
        "        return 2.0 * self.robot_radius_m + self.separation_m\n",
    ),
    _mutant(
        "reached-short",
        "A1: the goal is reached within its tolerance; here 0.33 m short of it",
        "agents/strand/leader.py",
        "(self._goal - position))) <= self._mission.goal_tolerance_m\n",
        "(self._goal - position))) <= self._mission.goal_tolerance_m + 0.33\n",
    ),
    _mutant(
        "arrives-on-its-way",
        "A2: a robot that has arrived stands, with the way up to the robot ahead behind it",
        "agents/strand/following.py",
        "        if there and state.arrived and not self._arrived:\n",
        "        if state.arrived and not self._arrived:\n",
    ),
)
