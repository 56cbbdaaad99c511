"""The mutants of views and fences: F1 to F6, and the rules of the schedules V1 to V23 (docs/mutants.md)."""

from clew.mutants.mutant import Edit, Mutant, mutant

OF_VIEWS = (
    mutant(
        "any-fence",
        "F1: a body obeys an order only if it bears exactly its fence",
        "protocol/fence.py",
        "    exactly = (bearing.epoch, bearing.turn) == (fence.epoch, fence.turn)\n",
        "    exactly = True\n",
        seed=144,
        breaks=("F1",),
    ),
    mutant(
        "drives-on",
        "F1: when the fence changes, all bodies stop and drop their orders",
        "world/bodies/arena.py",
        "        self.bodies.stand()\n        return [*samples, ",
        "        return [*samples, ",
        seed=2,
        breaks=("F1",),
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
        seed=4,
        breaks=("F1",),
    ),
    mutant(
        "next-life-drives",
        "F1: a turn names a life, and the next life of its robot does not use it",
        "protocol/fence.py",
        "(self.robot, self.life) == (robot, life)",
        "self.robot == robot",
        check="tests/unit/world/bodies/test_bodies.py::"
        "test_a_body_drives_only_by_an_order_that_bears_exactly_its_fence_which_names_the_robot",
    ),
    Mutant(
        "orders-untold",
        "F2: a robot orders motion only under the fence that its odometry tells",
        (
            Edit(
                "agents/body/driver.py",
                "return self._odometry is not None and self._is_told(self.bearing) and",
                "return self._odometry is not None and",
            ),
            Edit(
                "agents/membership/membership.py",
                "if self.state is State.BOUND and self.fence.may is May.ALL:",
                "if self.state is State.BOUND:",
            ),
            Edit(
                "agents/membership/membership.py",
                "if whole is None or whole[0].turn != self.fence.turn or not in_force(self.fence):",
                "if whole is None:",
            ),
        ),
        seed=11,
        breaks=("F2", "F5"),
    ),
    mutant(
        "any-turn",
        "F3: the register takes exactly the next turn, and none after ALL",
        "world/bodies/fence.py",
        "is_next = (fence.epoch, fence.turn) == (now.epoch, now.turn + 1) and now.may is not May.ALL",
        "is_next = fence.epoch == now.epoch and fence != now",
        seed=4,
        breaks=("F3",),
    ),
    mutant(
        "late-raises",
        "F3: a raise of the same generation replaces an epoch at turn 0 only",
        "world/bodies/fence.py",
        "epoch.generation == now.epoch.generation and now.turn == 0",
        "epoch.generation == now.epoch.generation",
        seed=134,
        breaks=("F3",),
    ),
    mutant(
        "raised-again",
        "F3: within a generation only a raise of a higher number is taken; here the same number is enough",
        "world/bodies/fence.py",
        "return is_tie and epoch.robot > now.epoch.robot",
        "return is_tie and epoch.robot >= now.epoch.robot",
        check="tests/unit/world/bodies/test_fence.py::"
        "test_the_higher_number_wins_within_a_generation_while_no_turn_was_taken",
    ),
    mutant(
        "raises-over-stop",
        "F3: over a stop no raise is taken",
        "world/bodies/fence.py",
        "or epoch.life == 0 or now.may is May.STOPPED:",
        "or epoch.life == 0:",
        check="tests/unit/world/test_fences.py::test_the_operator_stops_the_fleet_and_releases_it",
    ),
    mutant(
        "world-returns-as-it-was",
        "F3: a world that was started again raises the fence before it obeys or tells anything",
        "world/bodies/arena.py",
        "        return self._change(self._register.restart(now_s=self.now_s))\n",
        "        return []\n",
        check="tests/unit/world/test_fences.py::"
        "test_a_world_that_was_started_again_in_a_rehearsal_raises_the_fence_and_tells_it",
    ),
    mutant(
        "any-life-coordinates",
        "F3, F4: only the life that proposed a view coordinates it",
        "agents/membership/membership.py",
        "        if (epoch.robot, epoch.life) == (self._robot, self._life):\n",
        "        if epoch.robot == self._robot:\n",
        seed=17,
        breaks=("F3", "F4"),
    ),
    mutant(
        "fence-unwritten",
        "a change of the fence is in the timeline before it takes effect",
        "world/bodies/arena.py",
        "self.note(taken.as_record())]",
        "*([self.note(taken.as_record())] if taken.cause else self.sample())]",
        breaks=("F1", "F2", "F3"),
    ),
    Mutant(
        "old-places",
        "F4: a place in the formation is read after the last turn of its robot, and a member stands there",
        (
            Edit(
                "agents/coordinating/coordinator.py",
                "        self._reports[robot] = report\n",
                "        kept = {} if known is None else {'place': known.place}\n"
                "        report = __import__('msgspec').structs.replace(report, **kept)\n"
                "        self._reports[robot] = report\n",
            ),
            Edit("agents/strand/member.py", "self._misfit = off_m > mission.mu0_m", "self._misfit = False"),
        ),
        breaks=("F4",),
    ),
    mutant(
        "puts-untold",
        "F4: a coordinator puts the next turn only when its odometry has told the last",
        "agents/coordinating/turns.py",
        "return fence.turn >= self.newest.turn",
        "return True",
        check="tests/unit/agents/conversations/test_turns.py::"
        "test_v19_one_number_of_a_turn_has_one_content_however_long_its_put_is_held_up",
    ),
    mutant(
        "all-after-a-turn",
        "F4: the last turn before ALL names nobody, unless none named a robot",
        "agents/coordinating/coordinator.py",
        " and fence.may is not May.ONE and not self._awaited(now_s)\n",
        "\n",
        check="tests/unit/agents/conversations/test_turns.py::"
        "test_v5_an_order_of_a_turn_moves_no_body_under_all",
    ),
    mutant(
        "old-reports-end-turns",
        "F4: a report ends only the turn that it names",
        "agents/coordinating/coordinator.py",
        "        if report.ended >= fence.turn:\n",
        "        if report.ended > 0:\n",
        check="tests/unit/agents/conversations/test_turns.py::test_v16_an_old_report_ends_no_turn_that_was_given_later",
    ),
    mutant(
        "old-epochs-report",
        "F4: a report counts only in the epoch that it names; here one of an older epoch counts, too",
        "agents/membership/membership.py",
        "        if said.epoch != self.fence.epoch:\n            return []\n        reporter =",
        "        if said.epoch != self.fence.epoch and type(said) is not Report:\n            return []\n"
        "        reporter =",
        check="tests/unit/agents/conversations/test_turns.py::"
        "test_a_report_of_an_older_epoch_does_not_count_however_high_its_number",
    ),
    mutant(
        "misfits-drive",
        "F4: a member that does not stand at its place gives no order",
        "agents/strand/member.py",
        "self._misfit = off_m > mission.mu0_m",
        "self._misfit = False",
        check="tests/unit/agents/conversations/test_strands.py::"
        "test_v12_a_member_that_does_not_stand_at_its_place_says_nothing_and_raises",
    ),
    mutant(
        "next-life-acts",
        "F4: a formation names lives, and another life of a member does not act on it",
        "agents/membership/membership.py",
        "            case Formation() if reporter is not None and said.life == self._life:\n",
        "            case Formation() if reporter is not None:\n",
        check="tests/unit/agents/conversations/test_strands.py::"
        "test_v2_a_new_life_takes_no_part_in_the_formation_of_its_former_life",
    ),
    mutant(
        "pieces-are-all",
        "F4: a member acts only when it has all pieces of its formation",
        "agents/membership/assembly.py",
        "len(vertices) != self._pieces[0].vertices",
        "0 not in self._pieces",
        check="tests/unit/agents/coordinating/test_formation.py::"
        "test_pieces_in_any_order_lost_and_repeated_make_the_formation_when_all_are_there",
    ),
    mutant(
        "odometry-goes-back",
        "F4: of two odometries the one with the newer fence and number counts",
        "agents/body/driver.py",
        "        if self._odometry is not None and _age(odometry) <= _age(self._odometry):\n",
        "        if self._odometry is not None and odometry == self._odometry:\n",
        seed=7,
        breaks=("F4", "P2"),
    ),
    mutant(
        "unheard-is-near",
        "a neighbour that was never heard stands at its place in the formation",
        "agents/strand/grants.py",
        "            return self.behind_start_m\n        return self._behind.state.progress_m\n",
        "            return self.granted_m\n        return self._behind.state.progress_m\n",
        check="tests/unit/agents/strand/test_member.py::"
        "test_a_leader_that_hears_nobody_stops_when_the_strand_is_stretched",
    ),
    mutant(
        "legs-of-two-epochs",
        "a leg counts as driven only if both robots' places lie on one path of one epoch",
        "agents/membership/places.py",
        "(each for each in ahead if each.epoch == own.epoch and not each.draft)",
        "(each for each in ahead if not each.draft)",
        check="tests/unit/agents/membership/test_places.py::"
        "test_v23_a_leg_between_places_of_two_epochs_or_that_is_not_known_was_not_driven",
    ),
    mutant(
        "laid-through-bodies",
        "S1: a driven leg is laid where it was, and not from where bodies stand beside it",
        "agents/membership/places.py",
        "    return at if off_m > ON_LINE_M else Point(x_m=pose.x_m, y_m=pose.y_m)\n",
        "    return Point(x_m=pose.x_m, y_m=pose.y_m)\n",
        check="tests/rehearsals/test_driven_legs.py::test_drive_errors_do_not_add_up_from_view_to_view",
    ),
    mutant(
        "no-epoch-in-links",
        "F5: a link state of another epoch, or of another life, is void",
        "protocol/wire/link.py",
        "        return (robot, state.life, state.epoch) == (self.neighbour, self.life, self.epoch)\n",
        "        return robot == self.neighbour\n",
        check="tests/unit/protocol/wire/test_link.py::test_a_link_is_to_one_life_of_one_robot_in_one_epoch",
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
        seed=45,
        breaks=("F6",),
    ),
    mutant(
        "neighbours-hide-nothing",
        "M4 of docs/fleets.md: no hit is left out of a permission; here those within 0.6 m are",
        "agents/body/watch.py",
        "    walls = scan_walls(view, mission)  # rule 1: no hit is left out\n",
        "    walls = scan_walls(view, mission, leave_out=view.ranges_m < 0.6)\n",
        check="tests/unit/agents/conversations/test_two_fleets.py::"
        "test_a_robot_that_comes_out_from_behind_a_neighbour_is_not_touched",
    ),
    mutant(
        "epsilon-only",
        "F6: a hit that may be a robot is kept off by the separation where that is more than epsilon",
        "protocol/mission.py",
        "        return max(self.epsilon_m, self.separation_m)\n",
        "        return self.epsilon_m\n",
        check="tests/unit/agents/conversations/test_strands.py::"
        "test_v13_robots_that_are_left_out_are_passed_at_the_greater_of_epsilon_and_the_separation",
    ),
)
