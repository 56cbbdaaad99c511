#!/usr/bin/env bash
# Runs a fleet as real processes: a router, a world and the robots. `launch/fleet.sh --help` lists the options.
#
# Rule 1: the world's end is the end of the run, and its exit code is ours.
# Rule 2: a part that dies before the world ends the run with exit code 1, and stderr says who it was.
# Rule 3: INT, TERM and HUP end the run with 130, 143 and 129; every part is asked first and then killed.
# Rule 4: nothing stays behind but the run's folder. If this script is killed itself, its end of the
#         lifeline closes, which every part takes for a request to go.
set -uo pipefail
# Parts are started with redirections, which fail where a caller has closed these.
for descriptor in 0 1 2; do
    [[ -e /dev/fd/$descriptor ]] || eval "exec $descriptor<>/dev/null"
done
source "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/setup.sh"

# Together less than the 5 s in which everything has to be gone, report included.
grace_us=1500000  # for the world to notice by itself that robots have died: it takes 1 s to be sure
world_us=3000000  # for the world to close the books and write its verdict
others_us=400000  # for router and robots, which have nothing left to do by then
ready_us=10000000 # for the router to listen: it takes 0.3 s; more only on a machine that is overloaded

declare -A part=() # name of each part that has not ended, by process id
private= heir= world= run_folder= latest= as_json=0
made_folders=()

now_us() { printf -v "$1" '%s' "${EPOCHREALTIME/[.,]/}"; }

# Descriptor 9 is the lifeline; nobody ever writes to it, so reading from it is a pause without a process.
pause() { read -r -t 0.02 -u 9; }

# start NAME COMMAND...: in a process group of its own, so that a Ctrl-C reaches this script alone and
# that the robots can be found after their host has died.
start() {
    local name=$1
    shift
    set -m
    "$@" <"$private/lifeline" 9>&- &
    set +m
    started=$!
    part[$started]=$name
}

# await_groups US PID...: true when no process of these groups is left.
await_groups() {
    local now until pid left=1
    now_us until
    ((until += $1))
    shift
    while ((left)); do
        left=0
        for pid in "$@"; do
            kill -0 -- "-$pid" 2>/dev/null && left=1
        done
        now_us now
        ((left && now > until)) && return 1
        ((left)) && pause
    done
    return 0
}

signal_groups() {
    local signal=$1 pid
    shift
    for pid in "$@"; do
        kill "-$signal" -- "-$pid" 2>/dev/null
    done
}

# The world goes first, because the robots have to be there when it closes the books.
stop_parts() {
    local signal=$1
    if [[ -n $world ]]; then
        kill "-$signal" "$world" 2>/dev/null
        await_groups "$world_us" "$world"
    fi
    ((${#groups[@]})) || return
    signal_groups TERM "${groups[@]}"
    await_groups "$others_us" "${groups[@]}" && return
    clew_say "killing what has not gone when asked"
    signal_groups KILL "${groups[@]}"
    await_groups "$others_us" "${groups[@]}"
}

report() {
    if [[ -s $run_folder/verdict.json ]]; then
        if ((as_json)); then cat "$run_folder/verdict.json"; else "$python" -m lab.report "$run_folder"; fi
    elif [[ -s $run_folder/events.jsonl ]]; then
        clew_say "no verdict was written; what happened until then is in $run_folder"
    else
        drop_run
    fi
}

# The run never began: it leaves no folder behind, and no link to one.
drop_run() {
    ((${#made_folders[@]})) && rmdir "${made_folders[0]}" 2>/dev/null || return
    [[ -z $latest || -e $latest ]] || rm -f "$latest"
    rmdir "${made_folders[@]:1}" 2>/dev/null
}

# end CODE [SIGNAL]: whatever ends a run ends it here.
end() {
    trap '' INT TERM HUP
    disown -a # or bash would report each part that it has to kill
    stop_parts "${2:-TERM}"
    report
    exit "$1"
}

clean_up() {
    [[ -z $heir ]] || kill -KILL -- "-$heir" 2>/dev/null
    signal_groups KILL "${!part[@]}"
    [[ -z $private ]] || rm -rf -- "$private"
}

how() { if (($1 > 128)); then echo "was killed by SIG$(kill -l "$1")"; else echo "ended with exit code $1"; fi; }

await_router() {
    local router=$1 now until line
    now_us until
    ((until += ready_us))
    until read -r -t 0.05 -u 8 line; do
        now_us now
        if ! kill -0 "$router" 2>/dev/null; then
            wait "$router"
            local code=$?
            ((code == 2)) && end 2 # it has said why
            clew_say "the router $(how "$code") before it was ready"
            end 1
        elif ((now > until)); then
            clew_say "the router is not ready after $((ready_us / 1000000)) s"
            end 1
        fi
    done
}

# Returns when the world has ended; anybody else who ends in bad order ends the run.
watch_parts() {
    local who code name
    while :; do
        wait -n -p who "${!part[@]}" 2>/dev/null # where bash, too, says who was killed
        code=$?
        name=${part[$who]}
        unset "part[$who]"
        if [[ $name == world ]]; then
            [[ -s $run_folder/verdict.json ]] || clew_say "the world $(how "$code")"
            # What the user asked for was found good before: with our own router, now it is the run that failed.
            ((code == 2 && own_routers)) && code=1
            end "$code"
        elif [[ $name == router ]] || ((code != 0)); then
            clew_say "the $name $(how "$code") before the world"
            await_groups "$grace_us" "$world"
            end 1
        fi
    done
}

for option in "$@"; do
    if [[ $option == -h || $option == --help ]]; then
        set_up run
        exec "$python" -m lab.prepare --help
    fi
done

set_up run
groups=() asked=
# Until there is something to end, a signal is remembered.
trap 'asked=130' INT
trap 'asked=143' TERM
trap 'asked=129' HUP
trap clean_up EXIT

# A socket's path has 107 characters at most, so a long TMPDIR does not serve.
base=${TMPDIR:-/tmp}
((${#base} <= 80)) || base=/tmp
private=$(mktemp -d "$base/clew.XXXXXX") || clew_refuse "no folder for the run's sockets can be made in $base"
# A Ctrl-C reaches this child too; it has nothing to say to it.
settings=$(trap "" INT && "$python" -m lab.prepare "$private" "$@") || exit "${asked:-$?}"
eval "$settings" # robots, own_routers, world_options, robot_options, run_folder, made_folders, latest, as_json
trap 'end 130 INT' INT
trap 'end 143' TERM
trap 'end 129' HUP
[[ -z $asked ]] || end "$asked"

mkfifo "$private/lifeline" "$private/ready"
exec 9<>"$private/lifeline" 8<>"$private/ready"
# If this script is killed, its traps do not run: then this one, at the end of the lifeline, removes what is private.
set -m
{ while read -r _; do :; done; rm -rf -- "$private"; } <"$private/lifeline" 9>&- 8>&- &
heir=$!
set +m
disown "$heir"
if ((own_routers)); then
    start router "$python" -m protocol --sessions "$private" --lifeline >&8
    groups+=("$started")
    await_router "$started"
fi
start world "$python" -m world "${world_options[@]}" --session "$private/world.json" --out "$run_folder" --lifeline >&2
world=$started
groups+=("$started")
start "robots' host" "$python" -m agents --robots "1-$robots" "${robot_options[@]}" --sessions "$private" --lifeline >&2
groups+=("$started")
if [[ -n $latest ]]; then
    ln -s "$(basename "$run_folder")" "$latest.$$" 2>/dev/null && mv -Tf "$latest.$$" "$latest"
fi
watch_parts
