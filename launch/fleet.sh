#!/usr/bin/env bash
# Runs a fleet as real processes: a router, a world and the robots. `launch/fleet.sh --help` lists the options.
#
# Rule 1: this script finds Python and sets up. `clew run` takes its place, so that a signal for the one reaches
#         the other: it starts the parts, supervises them, and exits with the run's code (docs/processes.md).
set -uo pipefail
# If a caller has closed one of these, the first file that is opened would take its number.
for descriptor in 0 1 2; do
    [[ -e /dev/fd/$descriptor ]] || eval "exec $descriptor<>/dev/null"
done
# shellcheck source-path=SCRIPTDIR source=setup.sh
source "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/setup.sh"

set_up run
clew_become run "$@"
