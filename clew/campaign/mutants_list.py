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
    check: str = ""
    """The test that catches it, where no seed of a swarm has: what it needs, no swarm draws."""


def mutant_named(name: str) -> Mutant:
    """The mutant of this name."""
    return next(mutant for mutant in MUTANTS if mutant.name == name)


def _mutant(name: str, rule: str, file: str, before: str, after: str, *, check: str = "") -> Mutant:
    return Mutant(name, rule, (Edit(file, before, after),), check=check)


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
    Mutant(
        "any-order",
        "F1: a body obeys an order only from a robot and life that its fence names",
        (
            Edit(
                "protocol/fence.py",
                "    exactly = (bearing.epoch, bearing.turn) == (fence.epoch, fence.turn)\n",
                "",
            ),
            Edit(
                "protocol/fence.py",
                "    return exactly and fence.names(robot, bearing.life)\n",
                "    return True\n",
            ),
        ),
    ),
    _mutant(
        "next-life-drives",
        "F1: a turn names a life, and the next life of its robot does not use it",
        "protocol/fence.py",
        "(self.robot, self.life) == (robot, life)",
        "self.robot == robot",
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
                "agents/membership/membership.py",
                "if self.state is State.BOUND and self._fence.may is May.ALL:",
                "if self.state is State.BOUND:",
            ),
            Edit(
                "agents/membership/membership.py",
                "if whole is None or whole[0].turn != self._fence.turn or not in_force(self._fence):",
                "if whole is None:",
            ),
        ),
    ),
    _mutant(
        "any-turn",
        "F3: the register takes exactly the next turn, and none after ALL",
        "world/bodies/fence.py",
        "is_next = (fence.epoch, fence.turn) == (now.epoch, now.turn + 1) and now.may is not May.ALL",
        "is_next = fence.epoch == now.epoch and fence != now",
    ),
    _mutant(
        "late-raises",
        "F3: a raise of the same generation replaces an epoch at turn 0 only",
        "world/bodies/fence.py",
        "epoch.generation == now.epoch.generation and now.turn == 0",
        "epoch.generation == now.epoch.generation",
    ),
    _mutant(
        "raises-over-stop",
        "F3: over a stop no raise is taken",
        "world/bodies/fence.py",
        "or epoch.life == 0 or now.may is May.STOPPED:",
        "or epoch.life == 0:",
        check="tests/unit/world/test_fences.py::test_the_operator_stops_the_fleet_and_releases_it",
    ),
    _mutant(
        "world-returns-as-it-was",
        "F3: a world that was started again raises the fence before it obeys or tells anything",
        "world/bodies/arena.py",
        "        return self._change(self._register.restart(now_s=self.now_s))\n",
        "        return []\n",
        check="tests/unit/world/test_fences.py::"
        "test_a_world_that_was_started_again_in_a_rehearsal_raises_the_fence_and_tells_it",
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
    Mutant(
        "old-places",
        "F4: a place in the formation is read after the last turn of its robot, and a member stands there",
        (
            Edit(
                "agents/coordinating/coordinator.py",
                "        self._reports[robot] = report\n",
                "        kept = {} if known is None else {'place': known.place}\n"
                "        self._reports[robot] = __import__('msgspec').structs.replace(report, **kept)\n",
            ),
            Edit("agents/strand/member.py", "self._misfit = off_m > mission.mu0_m", "self._misfit = False"),
        ),
    ),
    _mutant(
        "reports-of-any-view",
        "F4: a place in the formation was told in this epoch",
        "agents/membership/membership.py",
        "        if said.epoch != self._fence.epoch:\n            return []\n",
        "",
    ),
    _mutant(
        "puts-untold",
        "F4: a coordinator puts the next turn only when its odometry has told the last",
        "agents/coordinating/turns.py",
        "return self._newest is None or fence.turn >= self._newest.turn",
        "return True",
        check="tests/unit/agents/conversations/test_turns.py::"
        "test_v19_one_number_of_a_turn_has_one_content_however_long_its_put_is_held_up",
    ),
    _mutant(
        "all-after-a-turn",
        "F4: the last turn before ALL names nobody, unless none named a robot",
        "agents/coordinating/coordinator.py",
        "        if fence.may is May.ONE:\n            return self._turns.put(fence, now_s, may=May.NOBODY)\n"
        "        if self._waits_for_places(draft.strand):\n            return []\n",
        "",
    ),
    _mutant(
        "old-reports-end-turns",
        "F4: a report ends only the turn that it names",
        "agents/coordinating/coordinator.py",
        "        if report.ended >= fence.turn:\n",
        "        if report.ended > 0:\n",
        check="tests/unit/agents/conversations/test_turns.py::test_v16_an_old_report_ends_no_turn_that_was_given_later",
    ),
    _mutant(
        "misfits-drive",
        "F4: a member that does not stand at its place gives no order",
        "agents/strand/member.py",
        "self._misfit = off_m > mission.mu0_m",
        "self._misfit = False",
        check="tests/unit/agents/conversations/test_strands.py::"
        "test_v12_a_member_that_does_not_stand_at_its_place_says_nothing_and_raises",
    ),
    _mutant(
        "next-life-acts",
        "F4: a formation names lives, and another life of a member does not act on it",
        "agents/membership/membership.py",
        "            case Formation() if from_coordinator and said.life == self._life:\n",
        "            case Formation() if from_coordinator:\n",
        check="tests/unit/agents/conversations/test_strands.py::"
        "test_v2_a_new_life_takes_no_part_in_the_formation_of_its_former_life",
    ),
    _mutant(
        "pieces-are-all",
        "F4: a member acts only when it has all pieces of its formation",
        "agents/membership/assembly.py",
        "len(vertices) != self._pieces[0].vertices",
        "0 not in self._pieces",
        check="tests/unit/agents/coordinating/test_formation.py::"
        "test_pieces_in_any_order_lost_and_repeated_make_the_formation_when_all_are_there",
    ),
    _mutant(
        "odometry-goes-back",
        "F4: of two odometries the one with the newer fence and number counts",
        "agents/body/driver.py",
        "        if self._odometry is not None and _age(odometry) <= _age(self._odometry):\n",
        "        if self._odometry is not None and odometry == self._odometry:\n",
    ),
    _mutant(
        "unheard-is-near",
        "a neighbour that was never heard stands at its place in the formation",
        "agents/strand/grants.py",
        "            return self.behind_start_m\n        return self._behind.state.progress_m\n",
        "            return self.granted_m\n        return self._behind.state.progress_m\n",
        check="tests/unit/agents/strand/test_member.py::"
        "test_a_leader_that_hears_nobody_stops_when_the_strand_is_stretched",
    ),
    _mutant(
        "legs-of-two-epochs",
        "a leg counts as driven only if both robots' places lie on one path of one epoch",
        "agents/membership/places.py",
        "(each for each in ahead if each.epoch == berth.epoch and not each.draft)",
        "(each for each in ahead if not each.draft)",
    ),
    _mutant(
        "no-epoch-in-links",
        "F5: a link state of another epoch, or of another life, is void",
        "protocol/wire/link.py",
        "        return (robot, state.life, state.epoch) == (self.neighbour, self.life, self.epoch)\n",
        "        return robot == self.neighbour\n",
    ),
    Mutant(
        "old-scans",
        "F6: a scan serves only under the very fence that it bears",
        (
            Edit(
                "agents/body/senses.py",
                "        return scan.fence == fence and in_force(fence)\n",
                "        return in_force(fence)\n",
            ),
            Edit("agents/membership/membership.py", "        self._senses.forget()\n", ""),
        ),
    ),
    _mutant(
        "silent-among-walkers",
        "F6: where obstacles move, nobody is taken out of a scan who was not heard for two heartbeats",
        "agents/strand/grants.py",
        "    return not mission.obstacles_move or now_s - link.heard_at_s <= fresh_s\n",
        "    return True\n",
        check="tests/unit/agents/strand/test_member.py::"
        "test_where_obstacles_move_a_silent_robot_is_not_taken_out_of_a_scan",
    ),
    _mutant(
        "epsilon-only",
        "F6: a hit that may be a robot is kept off by the separation where that is more than epsilon",
        "protocol/mission.py",
        "        return max(self.epsilon_m, self.separation_m)\n",
        "        return self.epsilon_m\n",
        check="tests/unit/agents/conversations/test_strands.py::"
        "test_v13_robots_that_are_left_out_are_passed_at_the_greater_of_epsilon_and_the_separation",
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
)
