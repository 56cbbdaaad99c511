#!/usr/bin/env bash
# Runs a fleet as real processes: a router, a world and the robots. `launch/fleet.sh --help` lists the options.
#
# Rule 1: the world's end is the end of the run, and its exit code is ours.
# Rule 2: a router that dies is started again, and so is a world that a signal has killed: it goes on from its own
#         timeline. A host that dies before the world ends the run with exit code 1. stderr says who it was.
# Rule 3: INT, TERM and HUP end the run with 130, 143 and 129; every part is asked first and then killed.
# Rule 4: nothing stays behind but the run's folder. If this script is killed itself, its end of the
#         lifeline closes, which every part takes for a request to go.
# Rule 5: what a fault plan does to the world or to a router comes by a pipe, a line each: `kill world`. Wall-clock
#         seconds may follow, after which it is undone: `kill router 2.5` starts it again no sooner.
# Rule 6: a viewer (--view) only reads what the world writes. What becomes of it is nothing to the run; it ends with it.
# Rule 7: a table, on a terminal, only reads likewise. While it is shown, or with --quiet, what the parts say goes into
#         a file; it comes out at the end, but for the progress. The terminal is left as it was.
# shellcheck disable=SC2154 # `eval "$settings"` sets what prepare.py has checked
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
private='' heir='' striker='' shows=lines world='' run_folder='' latest='' as_json=0
router_restarts_max=10 # in one run: enough for any plan, and an end to a router that cannot live
world_restarts_max=5
router_deaths=0 world_deaths=0
active=1 # the router that carries the fleet: all clients are with the other one when it has died
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
    "$@" <"$private/lifeline" 9>&- 7>&- &
    set +m
    started=$!
    part[$started]=$name
    groups+=("$started")
    echo "$started" >"$private/pid.new" && mv "$private/pid.new" "$private/$name.pid" # never half a number
}

remember_signals() {
    trap 'asked=130' INT
    trap 'asked=143' TERM
    trap 'asked=129' HUP
}

end_on_signals() {
    trap 'end 130 INT' INT
    trap 'end 143' TERM
    trap 'end 129' HUP
    [[ -z $asked ]] || end "$asked"
}

start_router() {
    start "router-$1" "$python" -m protocol --sessions "$private" --number "$1" --lifeline >&8
    ln -sfn "router-$active.pid" "$private/router.pid"
}

start_world() {
    start world "$python" -m world "$run_folder" --session "$private/world.json" --lifeline "$@" >&2
    world=$started
}

# It takes what time the fleet leaves.
start_viewer() {
    start viewer nice "$python" -m clew.cli view --live "$run_folder" --lifeline >"$private/address"
}

# The run waits for it, to be watched from its first moment; but not for long, nor for one that has died.
# A signal is remembered meanwhile: in a trap that interrupts `read`, bash does not learn that its children have ended.
await_viewer() {
    local viewer=$1 now until
    remember_signals
    now_us until
    ((until += ready_us))
    until [[ -s $private/address || -n $asked ]]; do
        now_us now
        ((now < until)) || break
        kill -0 "$viewer" 2>/dev/null || break
        pause
    done
    [[ ! -s $private/address ]] || clew_say "the page is at $(<"$private/address")"
    end_on_signals
}

# Descriptor 7 is stderr itself, while what everybody says to it goes into the file `said`.
hush() { exec 7>&2 2>>"$private/said"; }

start_table() {
    start table "$python" -m clew.fleet.table "$run_folder" --said "$private/said" >&7 2>&7
}

speak_up() {
    [[ $shows != lines ]] || return
    [[ $shows == table ]] && show_cursor
    shows=lines
    exec 2>&7 7>&-
    grep -Ev '^world: (t=|ok: |FAILED: )' "$private/said" >&2 # clew/fleet/table_said.py leaves out the same
}

# A table that was killed has not done it.
show_cursor() { printf '\e[?25h' >&7; }

mourn_table() {
    show_cursor
    printf '\e[0m\r\n\e[J' >&7 # it may have died within a line: what is said next has one of its own
    clew_say "the table $(how "$1"); the run goes on"
}

# forget PID: it has ended, so that what is called so next is another's.
forget() {
    local group left=()
    unset "part[$1]"
    for group in "${groups[@]}"; do
        # Of a dead host's group, robots may be left.
        [[ $group == "$1" ]] && ! kill -0 -- "-$group" 2>/dev/null || left+=("$group")
    done
    groups=("${left[@]}")
}

# await_groups US PID...: true when no process of these groups is left.
await_groups() {
    local now until pid some_left=1
    now_us until
    ((until += $1))
    shift
    while ((some_left)); do
        some_left=0
        for pid in "$@"; do
            kill -0 -- "-$pid" 2>/dev/null && some_left=1
        done
        now_us now
        ((some_left && now > until)) && return 1
        ((some_left)) && pause
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
        kill -CONT "$world" 2>/dev/null # a frozen one could not hear
        await_groups "$world_us" "$world"
    fi
    ((${#groups[@]})) || return
    signal_groups TERM "${groups[@]}"
    signal_groups CONT "${groups[@]}"
    await_groups "$others_us" "${groups[@]}" && return
    clew_say "killing what has not gone when asked"
    signal_groups KILL "${groups[@]}"
    await_groups "$others_us" "${groups[@]}"
}

report() {
    if [[ -s $run_folder/verdict.json ]]; then
        if ((as_json)); then cat "$run_folder/verdict.json"; else "$python" -m clew.fleet.summary "$run_folder"; fi
    elif [[ -s $run_folder/events.jsonl ]]; then
        clew_say "no verdict was written; what happened until then is in $run_folder"
    else
        drop_run
    fi
}

# The run never began: it leaves no folder behind, and no link to one.
drop_run() {
    rm -f -- "$run_folder"/{scenario,faults,run}.toml
    ((${#made_folders[@]})) && rmdir "${made_folders[0]}" 2>/dev/null || return
    [[ -z $latest || -e $latest ]] || rm -f "$latest"
    rmdir "${made_folders[@]:1}" 2>/dev/null
}

# end CODE [SIGNAL]: whatever ends a run ends it here.
end() {
    trap '' INT TERM HUP
    disown -a # or bash would report each part that it has to kill
    stop_parts "${2:-TERM}"
    speak_up
    report
    exit "$1"
}

clean_up() {
    speak_up
    signal_groups KILL ${heir:+"$heir"} ${striker:+"$striker"}
    signal_groups KILL "${!part[@]}"
    [[ -z $private ]] || rm -rf -- "$private"
}

how() { if (($1 > 128)); then echo "was killed by SIG$(kill -l "$1")"; else echo "ended with exit code $1"; fi; }

await_router() {
    local router=$1 now until
    now_us until
    ((until += ready_us))
    until read -r -t 0.05 -u 8 _; do
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

# Never returns: the world's end is the run's.
watch_parts() {
    local who code name
    while :; do
        wait -n -p who "${!part[@]}" 2>/dev/null # where bash, too, says who was killed
        code=$?
        name=${part[$who]}
        forget "$who"
        case $name in
        world) mourn_world "$code" ;;
        table) ((code == 0)) || mourn_table "$code" ;;
        viewer) clew_say "the viewer $(how "$code"); the run goes on" ;;
        router-*) mourn_router "${name#router-}" "$code" ;;
        away-*) start_again "${name#away-}" ;;
        *) ((code == 0)) || give_up "the $name $(how "$code") before the world" ;;
        esac
    done
}

give_up() {
    clew_say "$1"
    await_groups "$grace_us" ${world:+"$world"}
    end 1
}

# A world that ended by itself has written its verdict, or said why it could not.
mourn_world() {
    local code=$1
    if ((code > 128 && ++world_deaths <= world_restarts_max)) && [[ ! -s $run_folder/verdict.json ]]; then
        clew_say "the world $(how "$code"); it is started again"
        world=
        replace world
        return
    fi
    [[ -s $run_folder/verdict.json ]] || clew_say "the world $(how "$code")"
    # What the user asked for was found good before: with our own router, now it is the run that failed.
    ((code == 2 && own_routers)) && code=1
    end "$code"
}

mourn_router() {
    local number=$1 code=$2
    ((++router_deaths <= router_restarts_max)) || give_up "router $number $(how "$code") once too often"
    clew_say "router $number $(how "$code"); it is started again"
    ((number != active)) || active=$((own_routers + 1 - number))
    replace "router-$number"
}

# replace NAME: at once, or when there has been none for as long as rule 5 wants.
replace() {
    local away=$private/$1.away wall_s
    ln -sfn "router-$active.pid" "$private/router.pid"
    if { read -r wall_s <"$away" && rm -f "$away"; } 2>/dev/null; then
        start "away-$1" sleep "$wall_s"
    else
        start_again "$1"
    fi
}

start_again() {
    case $1 in
    world) start_world --resume ;;
    router-*) start_router "${1#router-}" ;;
    esac
}

# Rule 5: a child that does what the pipe says.
strike() {
    local blow process wall_s pid name
    while read -r blow process wall_s; do
        { read -r pid <"$private/$process.pid"; } 2>/dev/null || continue
        name=$(basename "$(readlink -f "$private/$process.pid")" .pid) # of the router, which of them
        case $blow in
        kill)
            [[ -z $wall_s ]] || echo "$wall_s" >"$private/$name.away" # read when it is mourned
            kill -KILL "$pid" 2>/dev/null || rm -f "$private/$name.away"
            ;;
        freeze)
            kill -STOP "$pid" 2>/dev/null
            [[ -z $wall_s ]] || { sleep "$wall_s" && kill -CONT "$pid"; } 2>/dev/null &
            ;;
        thaw) kill -CONT "$pid" 2>/dev/null ;;
        esac # who has been killed is started again anyway
    done
}

for option in "$@"; do
    if [[ $option == -h || $option == --help ]]; then
        set_up run
        exec "$python" -m clew.fleet.prepare --help
    fi
done

set_up run
groups=() asked=
remember_signals # until there is something to end
trap clean_up EXIT

# A socket's path has 107 characters at most, so a long TMPDIR does not serve.
base=${TMPDIR:-/tmp}
((${#base} <= 80)) || base=/tmp
private=$(mktemp -d "$base/clew.XXXXXX") || clew_refuse "no folder for the run's sockets can be made in $base"
# A Ctrl-C reaches this child too; it has nothing to say to it.
settings=$(trap "" INT && "$python" -m clew.fleet.prepare "$private" "$@") || exit "${asked:-$?}"
eval "$settings" # robots, own_routers, run_folder, made_folders, latest, as_json, view, shows
[[ $shows != table || -t 1 ]] || shows=lines # as in `fleet.sh | tee`
[[ $shows == lines ]] || hush
end_on_signals

mkfifo "$private/lifeline" "$private/ready" "$private/strokes"
exec 9<>"$private/lifeline" 8<>"$private/ready"
set -m
strike <>"$private/strokes" 9>&- 8>&- 7>&- &
striker=$!
# If this script is killed, its traps do not run: then this one, at the end of the lifeline, removes what is private.
{ while read -r _; do :; done; kill -KILL -- "-$striker"; rm -rf -- "$private"; } <"$private/lifeline" 9>&- 8>&- 7>&- &
heir=$!
set +m
disown "$striker" "$heir"
((view)) && start_viewer && viewer=$started
for ((number = 1; number <= own_routers; ++number)); do
    start_router "$number"
    await_router "$started"
done
((view)) && await_viewer "$viewer"
start_world
[[ $shows == table ]] && start_table
start host "$python" -m agents --robots "1-$robots" --host --run "$run_folder" --sessions "$private" --lifeline >&2
if [[ -n $latest ]]; then
    ln -s "$(basename "$run_folder")" "$latest.$$" 2>/dev/null && mv -Tf "$latest.$$" "$latest"
fi
watch_parts
