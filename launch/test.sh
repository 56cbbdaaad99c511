#!/usr/bin/env bash
# Checks everything: lint, format, types, then the tests, those with real processes last.
# Arguments go to both runs of pytest, so `launch/test.sh -k house` narrows them.
set -euo pipefail
source "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/setup.sh"
set_up dev
cd "$clew_root"

# Tests of the page want a browser, and are skipped where there is none. It comes from Debian, for who may install it:
#     apt-get install -y --no-install-recommends chromium
get_chromium() {
    command -v chromium >/dev/null || ((EUID)) || ! command -v apt-get >/dev/null && return
    clew_say "installing chromium, for the tests of the page"
    local apt=(apt-get -qq -o DPkg::Lock::Timeout=60)
    { "${apt[@]}" update && DEBIAN_FRONTEND=noninteractive "${apt[@]}" install -y --no-install-recommends chromium; } \
        >/dev/null 2>&1 || clew_say "chromium cannot be installed: the tests of the page will be skipped"
}
get_chromium

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
check_tests -m "not processes" -n auto --dist worksteal "$@"
check_tests -m processes "$@"
exit "$failed"
