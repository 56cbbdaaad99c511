"""The mutants of our source. Each breaks one rule on which safety or healing depends."""

from clew.mutants.mutant import Edit, Mutant
from clew.mutants.mutant import mutant as _mutant
from clew.mutants.of_views import OF_VIEWS

MUTANTS = (
    Mutant(
        "no-separation",
        "a grant ends at least `keep` before the ground that its granter may occupy",
        (
            Edit("agents/strand/grants.py", "progress_m - keep_m + THERE_M)", "progress_m)"),
            Edit("agents/strand/grants.py", "keep_m=keep_m)", "keep_m=0.0)"),
        ),
        breaks=("S2",),
    ),
    _mutant(
        "path-is-authority",
        "a robot drives only as far as its authority, even where it knows more of the path",
        "agents/strand/strand.py",
        "self.authority_m = max(self.authority_m, state.authority_m)",
        "self.authority_m = self.path.end_m",
        breaks=("S2", "F5"),
    ),
    _mutant(
        "hairpins",
        "grants keep distance in the plane, not only along the path",
        "protocol/wire/authority.py",
        "    ground = path.corners(progress_m, path.end_m)\n",
        "    return max(from_m, progress_m - keep_m)\n    ground = path.corners(progress_m, path.end_m)\n",
        seed=15,
        breaks=("S2",),
    ),
    _mutant(
        "leader-over-grants",
        "the leader's next step stays clear of all granted ground",
        "agents/navigation/certificate.py",
        "np.full(len(corners) - 1, keep_m)",
        "np.full(len(corners) - 1, 0.0 * keep_m)",
        seed=18,
        breaks=("S2",),
    ),
    *OF_VIEWS,
    _mutant(
        "hulls-are-members",
        "F6: hits are robots of the strand only where a neighbour may be",
        "agents/strand/strand.py",
        "            grounds.append(self.path.between(self._ahead_m, self.path.end_m))\n",
        "            grounds.append(self.path.between(0.0, self.path.end_m))\n",
        check="tests/unit/agents/conversations/test_sight.py::"
        "test_of_the_robot_ahead_hits_count_from_where_it_was_last_heard_on",
    ),
    _mutant(
        "no-dead-man",
        "a body stops when its robot sends no orders",
        "world/bodies/body.py",
        "now_s - self.basis_s > DEADMAN_S + ROUNDING_S",
        "now_s - self.basis_s > 1e9",
        check="tests/unit/world/bodies/test_bodies.py::"
        "test_a_body_stops_once_when_its_robot_is_silent_and_continues_when_it_sends",
    ),
    _mutant(
        "numbers-again",
        "the orders of a restarted robot have higher numbers than those of its former life",
        "agents/body/driver.py",
        "        number = max(self.odometry.ordered, int(self.odometry.t_s * NUMBERS_PER_S)) + LATE_ORDERS\n",
        "        number = 0\n",
        seed=27,
        breaks=("liveness",),
    ),
    _mutant(
        "no-checksum",
        "a damaged message is refused",
        "protocol/wire/codec.py",
        "    if _seal(content, key) != payload[-SEAL_BYTES:]:",
        "    if len(payload) < SEAL_BYTES:",
        seed=9,
        breaks=("F4", "F5", "P4"),
    ),
    _mutant(
        "no-epsilon",
        "steps and segments keep epsilon from obstacles",
        "protocol/mission.py",
        "        return self.robot_radius_m + max(self.clear_m, ",
        "        return self.robot_radius_m + max(0.0, ",
        seed=6,
        breaks=("S1",),
    ),
    Mutant(
        "lenient-monitor",
        "S1, S2: the world counts each breach, however small; robots keep 15 mm less than they promise",
        (
            Edit(
                "world/judge/monitor.py",
                "    return (distance_m <= 0.0) | (distance_m < required_m - ROUNDING_M)\n",
                "    return distance_m < required_m - 0.02\n",
            ),
            Edit(
                "protocol/mission.py",
                "        return self.robot_radius_m + max(self.clear_m, ",
                "        return self.robot_radius_m + max(self.clear_m - 0.015, ",
            ),
        ),
        seed=24,
        breaks=("judges",),
    ),
    _mutant(
        "neighbours-uncompared",
        "S2: the world compares all pairs of robots, also those that follow each other",
        "world/judge/monitor.py",
        "np.triu(apart_m <= near_m + self._slack_m, k=1)",
        "np.triu(apart_m <= near_m + self._slack_m, k=2)",
        breaks=("judges",),
    ),
    _mutant(
        "late-orders",
        "a body refuses an order that is older, by number, than one that it has accepted",
        "world/bodies/body.py",
        "        if drive.number < self.ordered or drive.basis_s < self.basis_s:\n",
        "        if False:\n",
        check="tests/unit/world/bodies/test_bodies.py::"
        "test_an_older_order_that_arrives_late_does_not_keep_the_body_moving",
    ),
    Mutant(
        "dead-man-by-arrival",
        "an order expires a fixed time after the odometry that it is based on, not after its arrival",
        (
            Edit(
                "world/bodies/body.py",
                "if not now_s - DEADMAN_S - ROUNDING_S <= drive.basis_s <= now_s + ROUNDING_S:",
                "if drive.basis_s > now_s + ROUNDING_S:",
            ),
            Edit(
                "world/bodies/body.py",
                "        self.basis_s, self._until_s = drive.basis_s, until_s",
                "        self.basis_s, self._until_s = now_s, until_s",
            ),
        ),
        check="tests/unit/world/bodies/test_bodies.py::"
        "test_the_dead_man_time_counts_from_the_basis_and_not_from_the_arrival_of_an_order",
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
                "        clear = leg_is_clear(seen, ahead, self.mission)\n",
                "        clear = True\n",
            ),
        ),
        breaks=("S1", "F6"),
    ),
    _mutant(
        "silence-unnoticed",
        "a link that is silent for too long is broken",
        "protocol/wire/link.py",
        "        return max(0.0, now_s - max(self.heard_at_s, self.made_at_s))\n",
        "        return 0.0\n",
        check="tests/unit/protocol/wire/test_link.py::"
        "test_a_link_without_any_state_is_silent_since_its_creation",
    ),
    _mutant(
        "acknowledges-unheard",
        "the robot behind acknowledges only the vertices that it knows",
        "agents/strand/news.py",
        "            handed=own.handed.number,\n            vertices=len(self._path),\n",
        "            handed=own.handed.number,\n            vertices=len(self._path) + 2,\n",
        seed=6,
        breaks=("liveness",),
    ),
    _mutant(
        "number-one-again",
        "a restarted robot's order numbers are higher even if its body accepted no order of the former life",
        "agents/body/driver.py",
        "        number = max(self.odometry.ordered, int(self.odometry.t_s * NUMBERS_PER_S)) + LATE_ORDERS\n",
        "        number = self.odometry.ordered + (LATE_ORDERS if self.odometry.ordered else 0)\n",
        check="tests/unit/agents/body/test_driver.py::"
        "test_the_orders_of_each_life_have_higher_numbers_even_if_the_body_accepted_none_before",
    ),
    _mutant(
        "promises-more",
        "S4: a step keeps the clearance that it promised; here it promises 30 mm more",
        "agents/navigation/certificate.py",
        "    return max(0.0, float(apart_m.min()) - mission.robot_radius_m)\n",
        "    return max(0.0, float(apart_m.min()) - mission.robot_radius_m) + 0.03\n",
        breaks=("S4",),
    ),
    _mutant(
        "keep-without-mu0",
        "A2: two robots keep the separation and the tolerance, since both may be off their path",
        "protocol/mission.py",
        "max(separation_m, moment_m) + mu0_m\n",
        "max(separation_m, moment_m)\n",
        check="tests/unit/agents/strand/test_strand.py::"
        "test_a_robot_grants_the_path_behind_it_minus_the_distance_to_keep",
    ),
    _mutant(
        "grants-within-epsilon",
        "where a strand closes up, a robot that dies locks in none beside it",
        "protocol/mission.py",
        "apart_m = self.epsilon_m if self.promises_clearance else 0.0",
        "apart_m = 0.0",
        check="tests/unit/agents/conversations/test_arrived.py::"
        "test_robots_of_a_strand_that_has_closed_up_are_one_again_without_a_move",
    ),
    _mutant(
        "reached-short",
        "A1: the goal is reached within its tolerance; here 0.33 m short of it",
        "agents/strand/leader.py",
        "(self._goal - position))) <= self._mission.goal_tolerance_m\n",
        "(self._goal - position))) <= self._mission.goal_tolerance_m + 0.33\n",
        seed=5,
        breaks=("A1",),
    ),
    _mutant(
        "arrives-on-its-way",
        "A2: a robot that has arrived stands, with the way up to the robot ahead behind it",
        "agents/strand/advance.py",
        "        if there and state.arrived and not self._arrived:\n",
        "        if state.arrived and not self._arrived:\n",
        breaks=("A2",),
    ),
    Mutant(
        "dead-man-doubled",
        "a body stops one second after the basis of its order; here after two, and robots still count on one",
        (
            Edit(
                "world/bodies/body.py",
                "from protocol.mission import DEADMAN_S\n",
                "from protocol.mission import DEADMAN_S as ASKED_S\n",
            ),
            Edit(
                "world/bodies/body.py",
                "ROUNDING_M = 1e-9  #",
                "DEADMAN_S = 2 * ASKED_S\nROUNDING_M = 1e-9  #",
            ),
        ),
        check="tests/unit/world/bodies/test_bodies.py::"
        "test_a_body_stops_once_when_its_robot_is_silent_and_continues_when_it_sends",
    ),
    _mutant(
        "open-polygon",
        "the free polygon of a scan has an edge for each gap between two rays; here one in fifty is left out",
        "agents/navigation/certificate.py",
        "    is_known = np.isfinite(seen.ranges_m)\n",
        "    is_known = np.isfinite(seen.ranges_m) & (np.arange(len(seen.ranges_m)) % 50 != 49)\n",
        check="tests/unit/agents/navigation/test_certificate.py::"
        "test_the_ground_that_a_scan_is_sure_of_has_an_edge_all_around",
    ),
    _mutant(
        "skipped-checks",
        "a follower checks each segment; here it skips one check in ten",
        "agents/strand/follower.py",
        "        return not self._mission.promises_clearance or",
        "        return hash(reach_m) % 10 == 0 or",
        breaks=("S1", "F6"),
    ),
    _mutant(
        "empty-map",
        "a leader hands its map over; here the map is empty",
        "agents/strand/memory.py",
        '        return self._handed or (b"" if self._leader is None else self._leader.map.packed())\n',
        '        return b""\n',
        check="tests/unit/agents/strand/test_handover.py::"
        "test_a_successor_continues_the_count_of_steps_and_knows_what_the_leader_saw",
    ),
    _mutant(
        "unordered-vertices",
        "vertices of the path are told in its order",
        "protocol/path.py",
        "        return tuple(self._vertices[first : first + most])\n",
        "        return tuple(self._vertices[first : first + most][::-1])\n",
        seed=6,
        breaks=("liveness",),
    ),
    _mutant(
        "learns-over-gaps",
        "a robot learns no vertices beyond a gap in what it knows of the path",
        "protocol/path.py",
        "        if first > len(self):\n            return\n        last = len(self) - 1\n",
        "        first = min(first, len(self))\n        last = len(self) - 1\n",
        check="tests/unit/protocol/test_path.py::"
        "test_vertices_beyond_a_gap_are_ignored_until_they_are_sent_again",
    ),
    _mutant(
        "replays-nothing",
        "a replay compares each decision with the recorded one",
        "clew/log/replay.py",
        "        if packed(decided) != packed(turn.decision):\n",
        "        if False:\n",
        check="tests/unit/clew/log/test_replay.py::test_a_changed_core_is_found",
    ),
    _mutant(
        "eaten-entry",
        "a world that is started again keeps the last whole entry of its timeline",
        "world/record/resume.py",
        '(newline := file.read(min(READ_BYTES, end - at)).rfind(b"\\n"))',
        '(newline := file.read(min(READ_BYTES, end - at)).rpartition(b"\\n")[0].rfind(b"\\n"))',
        check="tests/unit/world/record/test_resume.py::"
        "test_an_incomplete_line_is_removed_and_numbers_continue",
    ),
    _mutant(
        "deaths-forgiven",
        "a run in which a robot died, and nobody had asked for that, has failed",
        "world/judge/verdict.py",
        "    dated += [(death.cause_s, _death_sentence(death)) for death in recovery.unrequested]\n",
        "",
        check="tests/unit/world/judge/test_verdict.py::test_each_broken_promise_fails_the_run_and_is_named",
    ),
    _mutant(
        "one-arrival-ends",
        "a run is over only when every living robot has arrived; here one is enough",
        "world/core.py",
        "        if living and tally.arrived >= living:",
        "        if living and tally.arrived:",
        breaks=("liveness",),
    ),
)


def mutant_named(name: str) -> Mutant:
    """The mutant of this name."""
    return next(mutant for mutant in MUTANTS if mutant.name == name)
