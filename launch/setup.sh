# shellcheck shell=bash
# Sourced by every script of this folder: finds Python, keeps `.venv` up to date, sets $clew_root and $python.
# CLEW_VENV names another folder for the environment, so that nothing has to be written where the sources are.
#
# Rule 1: stdout belongs to the caller; whatever is said here goes to stderr.
# Rule 2: the stamp is written first, as `unfinished`, and is completed last. An unfinished environment is never used.
# Rule 3: a folder without our stamp is not ours: unless it is empty, it is neither changed nor used.
# Rule 4: what cannot work ends the script with one line and exit code 2; a Ctrl-C, with one line and 130.
# Rule 5: everything installed is named in requirements.lock, and its hash is checked.

clew_say() { printf 'clew: %s\n' "$*" >&2; }

clew_refuse() {
    clew_say "$*"
    exit 2
}

# The scripts need bash 4.4 (an empty array under `set -u`); with less than 5.1 they were never tried.
if ((BASH_VERSINFO[0] * 100 + BASH_VERSINFO[1] < 501)); then
    clew_refuse "bash 5.1 or newer is needed, this is $BASH_VERSION"
fi

clew_root=$(dirname "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")")
clew_venv=$clew_root/.venv
if [[ -n ${CLEW_VENV-} ]]; then
    [[ $CLEW_VENV == /* ]] || CLEW_VENV=$PWD/$CLEW_VENV # exported, it means the same in another folder
    clew_venv=$CLEW_VENV
fi
clew_stamp_file=$clew_venv/clew.stamp
python=$clew_venv/bin/python

# Ours come first whatever a sourced ROS has put there, and never from the folder that we are called in.
export PYTHONPATH=$clew_root${PYTHONPATH:+:$PYTHONPATH} PYTHONSAFEPATH=1
# Five processes on two cores: numpy's own threads only get in each other's way.
export OPENBLAS_NUM_THREADS=1

# clew_become ARGUMENTS: the command line takes our place. A Ctrl-C waits until it can say how it ends: while Python
# itself starts, it would print a traceback (protocol/process/loading.py). `env` of coreutils 8.31 or newer can do that.
clew_become() {
    local held=()
    ! env --block-signal=INT true 2>/dev/null || held=(env --block-signal=INT)
    exec "${held[@]}" "$python" -m clew.cli "$@"
}

# Prints what the stamp of an up-to-date environment says; fails where the environment's Python does not run.
clew_stamp() {
    local version
    version=$(trap '' INT && "$python" -IS -c 'import sys; print(*sys.version_info[:3], sep=".")' 2>/dev/null) || return 1
    printf '%s %s %s\n' "$(cat "$clew_root"/{pyproject.toml,requirements.lock} | cksum)" "$version" "$clew_root"
}

# The environment for tests serves for tools and runs as well, so a stamp with more is a stamp.
clew_holds() { [[ $1 == "$2" || " run  tools  dev " == *" $2 "*" $1 "* ]]; }

clew_is_ready() {
    local extra=$1 made_for stamped
    [[ -r $clew_stamp_file ]] && { read -r made_for && read -r stamped; } <"$clew_stamp_file" || return 1
    clew_holds "$made_for" "$extra" && [[ $stamped == "$(clew_stamp)" ]]
}

clew_find_python() {
    local candidate
    for candidate in python3 python3.13 python3.12 python3.11; do
        if "$candidate" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then
            command -v "$candidate"
            return
        fi
    done
    clew_refuse "Python 3.11 or newer is needed; python3 is $(python3 -V 2>/dev/null || echo 'not there')"
}

# clew_tell COUNT: says from pip's own lines, on stdin, how far it has come with so many packages.
clew_tell() {
    local line count=$1 fetched=0
    while IFS= read -r line; do
        case $line in
            "Collecting "* | "Processing "* | "Requirement already satisfied: "*)
                ((++fetched % 10)) || clew_say "$fetched of $count packages fetched"
                ;;
            "Installing collected packages: "*) clew_say "all $count packages fetched; unpacking them" ;;
        esac
    done
}

# clew_pip COUNT ARGS: errors of pip are seen, since they go to stderr.
clew_pip() {
    local count=$1
    "$python" -m pip install --disable-pip-version-check --progress-bar off "${@:2}" | clew_tell "$count"
    return "${PIPESTATUS[0]}"
}

# The pins that are needed come first, by hash; then we ourselves, for which nothing is downloaded any more.
clew_install() {
    local extra=$1 base=$2 pins=$clew_venv/requirements.txt count
    local pinned=(--require-hashes --requirement "$pins") ours=(--no-deps --no-build-isolation --editable "$clew_root")
    # Of what the tests install they import a fifth, which is compiled as it is first imported.
    local compiled=(--compile-bytecode)
    [[ $extra != dev || -n ${PYTHONDONTWRITEBYTECODE-} ]] || compiled=()
    [[ $extra != run ]] || extra=
    "$base" -IS "$clew_root/launch/locked.py" ${extra:+"$extra"} >"$pins" || return
    count=$(sed -n 's/^\([a-z0-9-]*\)==.*/\1/p' "$pins" | sort -u | wc -l) # of some, two versions are pinned
    clew_say "installing $count packages"
    if command -v uv >/dev/null; then
        [[ -w ${HOME-} ]] || local -x UV_CACHE_DIR=${UV_CACHE_DIR-$clew_venv/cache} # without a home, uv ends
        uv venv --quiet --no-project --allow-existing --python "$base" "$clew_venv" &&
            uv pip install --quiet "${compiled[@]}" --python "$python" "${pinned[@]}" &&
            uv pip install --quiet --python "$python" "${ours[@]}"
    else
        "$base" -m venv "$clew_venv" &&
            clew_pip "$count" "${pinned[@]}" &&
            clew_pip 1 --quiet "${ours[@]}"
    fi
}

# clew_alone COMMAND: runs it as a job of its own. A Ctrl-C reaches only us, and we end the job (rule 4).
clew_alone() {
    local job
    set -m
    "$@" >&2 </dev/null &
    job=$!
    set +m
    trap 'clew_break "$job" 129' HUP
    trap 'clew_break "$job" 130' INT
    trap 'clew_break "$job" 143' TERM
    wait "$job"
}

clew_break() {
    trap '' HUP INT TERM
    kill -- "-$1" 2>/dev/null || true
    wait "$1" 2>/dev/null || true
    clew_say "setting up $clew_venv was interrupted; nothing of it will be used"
    exit "$2"
}

clew_use() { case $1 in tools) echo "figures, exports and maps" ;; dev) echo tests ;; *) echo runs ;; esac; }

# clew_claim EXTRA: marks the environment as unfinished and sets $made_for, what it is to serve for, and $doing.
# What works is kept, since a test may be running in it, and is brought up to date; what is half-made is emptied.
clew_claim() {
    made_for=$1
    doing="setting up $clew_venv"
    [[ -w $clew_venv ]] || clew_refuse "$clew_venv is not up to date, nor writable: CLEW_VENV names another place"
    if [[ -e $clew_stamp_file ]]; then
        local before
        read -r before <"$clew_stamp_file"
        if [[ $before != unfinished ]] && clew_stamp >/dev/null; then
            doing="adding the libraries for $(clew_use "$made_for") to $clew_venv"
            if clew_holds "$before" "$made_for"; then
                made_for=$before
                doing="bringing $clew_venv up to date"
            fi
        else
            find "$clew_venv/" -mindepth 1 -delete
        fi
    elif [[ -n $(ls -A "$clew_venv") ]]; then
        clew_refuse "$clew_venv was not made by Clew: remove it, or name another place in CLEW_VENV"
    fi
    echo unfinished >"$clew_stamp_file"
}

# Runs under the lock, in a subshell: the environment is made, or the script that wants it ends.
clew_make() {
    local extra=$1 base made_for doing
    clew_is_ready "$extra" && return
    base=$(clew_find_python) || exit
    clew_claim "$extra"
    # Only its own Python can extend what was kept; another one may come first since, as after `conda activate`.
    base=$("$python" -IS -c 'import sys; print(sys._base_executable)' 2>/dev/null || echo "$base")
    SECONDS=0
    clew_say "$doing with $("$base" -V) (once; a minute or two)"
    clew_alone clew_install "$made_for" "$base" || clew_refuse "setting up $clew_venv failed, see above; nothing of it will be used"
    printf '%s\n' "$made_for" "$(clew_stamp)" >"$clew_stamp_file.new"
    mv "$clew_stamp_file.new" "$clew_stamp_file"
    clew_say "$clew_venv is ready, after $SECONDS s"
}

# set_up run|tools|dev: returns with an environment that holds what a run needs, what figures, exports and
# maps need beside, or what the tests need.
set_up() {
    clew_is_ready "$1" && return
    command -v flock >/dev/null || clew_refuse "flock (util-linux) is needed to set up"
    [[ -d $clew_venv ]] || mkdir -p "$clew_venv" 2>/dev/null ||
        clew_refuse "$clew_venv cannot be made: CLEW_VENV names another place for it"
    (flock 9 && clew_make "$1") 9<"$clew_venv" || exit
}
