#!/usr/bin/env bash
# Checks everything: lint, format, types, then the tests, those with real processes last.
# Arguments go to both runs of pytest, so `launch/test.sh -k house` narrows them.
set -euo pipefail
source "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/setup.sh"
set_up dev
cd "$clew_root"

failed=0
check() {
    clew_say "$*"
    "$python" -m "$@" || failed=1
}

# A choice (-k, a file) may leave one of the two runs of pytest without a test, which is no failure.
check_tests() {
    local code=0
    clew_say "pytest $*"
    "$python" -m pytest "$@" || code=$?
    ((code == 0 || (code == 5 && chosen))) || failed=1
}

chosen=$(($# > 0))
check ruff check
check ruff format --check
check mypy
check_tests -m "not processes" "$@"
check_tests -m processes "$@"
exit "$failed"
