#!/usr/bin/env bash
# Checks everything: lint and format, then the tests; those with real processes, types and scripts go beside them.
# Arguments go to both runs of pytest, so `launch/test.sh -k house` narrows them.
#
# It installs nothing outside its environment. What it cannot check for want of a browser, or of Node.js, it names.
set -euo pipefail
case ${1-} in
-h | --help)
    cat <<'USAGE'
Usage: launch/test.sh [--long] [PYTEST ARGUMENTS]

  Checks lint, format, types, shell scripts and the tests, with an environment of its own (.venv; a minute or two
  the first time). It takes five to ten minutes on two cores, and exits with 0 if all is well, else with 1.

  With --long, also the tests that show again what another one shows, with more seeds, robots or loss, and those
  that try the benchmarks: some six minutes more. Properties are then tried with three times as many.

  Examples:
    launch/test.sh
    launch/test.sh --long
    launch/test.sh -k house        # only the tests with this word in their names
    launch/test.sh tests/unit/world
USAGE
    exit
    ;;
esac
short=" and not long"
more=()
[[ ${1-} != --long ]] || { short="" && more=(--hypothesis-profile=long) && shift; }
# Hundreds of processes start in the tests: each would compile all of its modules anew.
unset PYTHONDONTWRITEBYTECODE
source "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/setup.sh"
set_up dev
cd "$clew_root"

said=$(mktemp -d) # by what runs beside something else; and the names of all that has failed
beside=()
trap 'rm -rf "$said"; ((${#beside[@]} == 0)) || kill -- "${beside[@]/#/-}" 2>/dev/null || true' EXIT
note_failed() {
    echo "$1" >>"$said/failed"
}

check() {
    clew_say "$*"
    "$python" -m "$@" || note_failed "$1"
}

check_shell() {
    local scripts
    mapfile -t scripts < <(find .ci launch tests -type f \( -name '*.sh' -o ! -name '*.*' \))
    clew_say "shellcheck ${scripts[*]}"
    "$clew_venv/bin/shellcheck" --external-sources --source-path=SCRIPTDIR "${scripts[@]}" || note_failed shellcheck
}

# TypeScript comes from npm, by a lock with its hash, into a folder of our environment.
get_typescript() {
    local asked=tests/support/page_types/package-lock.json had=$clew_venv/typescript/installed.json
    cmp --silent "$asked" "$had" && return
    rm -rf "$clew_venv/typescript" && mkdir "$clew_venv/typescript" || return
    cp tests/support/page_types/package*.json "$clew_venv/typescript" || return
    npm ci --prefix "$clew_venv/typescript" --cache "$clew_venv/typescript/cache" --ignore-scripts --silent || return
    cp "$asked" "$had"
}

check_page() {
    { command -v node && command -v npm; } >/dev/null || { clew_say "no Node.js with npm here: the types of the page are not checked" && return; }
    get_typescript || { clew_say "npm cannot install TypeScript: the types of the page are not checked" && return; }
    clew_say "tsc --project tests/support/page_types"
    node "$clew_venv/typescript/node_modules/typescript/bin/tsc" --project tests/support/page_types || note_failed tsc
}

# A choice (-k, a file) may leave one of the two runs of pytest without a test, which is no failure.
check_tests() {
    local code=0
    clew_say "pytest $*"
    "$python" -m pytest "$@" "${more[@]}" || code=$?
    ((code == 0 || (code == 5 && chosen))) || note_failed "pytest $1 $2"
}

# A fleet waits more than it computes: two for each core. Tests of a file share what they have set up; the longest
# files come first, and the many short ones of the browser last.
# Each worker collects all that it is given, so where nothing is chosen it is given the files with such tests only.
check_fleets() {
    local where=()
    ((chosen)) || mapfile -t where < <(printf '%s\n' tests/processes tests/browser && grep -rl 'mark\.processes' --include='test_*.py' tests/rehearsals tests/unit | sort)
    command -v chromium >/dev/null ||
        clew_say "no chromium here: its tests are skipped. To install it: apt-get install -y --no-install-recommends chromium"
    check_tests -m "processes$short" -n $(($(nproc) * 2)) --dist loadfile --no-loadscope-reorder "${where[@]}" "$@"
}

check_types_and_scripts() {
    check mypy
    check mypy launch/locked.py # in no package: ROS 2 owns the name `launch`
    check_shell
    check_page
}

# All workers collect from the same first file on: if no test is compiled yet, each would compile them all.
compile_tests() {
    ((chosen)) || compgen -G 'tests/__pycache__/*pytest*' >/dev/null ||
        "$python" -m pytest --collect-only -qq >/dev/null 2>&1 || true # the runs themselves tell what is wrong
}

chosen=$(($# > 0))
check ruff check
check ruff format --check
set -m # so that each of the two jobs beside the tests is a process group, which an interrupt ends
check_types_and_scripts >"$said/types" 2>&1 &
beside+=($!)
set +m
compile_tests
set -m
check_fleets "$@" >"$said/fleets" 2>&1 &
beside+=($!)
set +m
# What only computes gives way to the fleets, and computes while those wait.
renice -n 19 -p $$ -g "${beside[0]}" >/dev/null || true # without util-linux it costs the tests some time
check_tests -m "not processes$short" -n auto --dist worksteal "$@"
tail -n +1 -f --pid="${beside[1]}" "$said/fleets"
for each in "${beside[@]}"; do
    wait "$each" || note_failed "what ran beside the tests"
done
cat "$said/types"
[[ ! -e $said/failed ]] && exit
clew_say "failed: $(paste -sd ';' "$said/failed")"
exit 1
