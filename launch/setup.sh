# Sourced by every script of this folder: finds Python, keeps `.venv` up to date, sets $clew_root and $python.
#
# Rule 1: stdout belongs to the caller; whatever is said here goes to stderr.
# Rule 2: the stamp is written last, so an environment without one is half-made and is never used.
# Rule 3: what cannot work ends the script with one line and exit code 2.

clew_say() { printf 'clew: %s\n' "$*" >&2; }

clew_refuse() {
    clew_say "$*"
    exit 2
}

# `wait -n -p`, by which the launcher learns which part has ended, came with bash 5.1.
if ((BASH_VERSINFO[0] * 100 + BASH_VERSINFO[1] < 501)); then
    clew_refuse "bash 5.1 or newer is needed, this is $BASH_VERSION"
fi

clew_root=$(dirname "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")")
clew_venv=$clew_root/.venv
python=$clew_venv/bin/python

# Ours come first whatever a sourced ROS has put there, and never from the folder that we are called in.
export PYTHONPATH=$clew_root${PYTHONPATH:+:$PYTHONPATH} PYTHONSAFEPATH=1
# Five processes on two cores: numpy's own threads only get in each other's way.
export OPENBLAS_NUM_THREADS=1

# Prints what the stamp of an up-to-date environment says; fails where the environment's Python does not run.
clew_stamp() {
    local version
    version=$(trap '' INT && "$python" -IS -c 'import sys; print(*sys.version_info[:3], sep=".")' 2>/dev/null) || return 1
    printf '%s %s %s\n' "$(cksum <"$clew_root/pyproject.toml")" "$version" "$clew_root"
}

# The environment for tests serves for tools and runs as well, so a stamp with more is a stamp.
clew_holds() { [[ $1 == "$2" || " run  tools  dev " == *" $2 "*" $1 "* ]]; }

clew_is_ready() {
    local extra=$1 made_for stamped
    [[ -r $clew_venv/clew.stamp ]] && { read -r made_for && read -r stamped; } <"$clew_venv/clew.stamp" || return 1
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

clew_install() {
    local extra=$1 base=$2 requirement=$clew_root
    [[ $extra == run ]] || requirement="$clew_root[$extra]"
    if command -v uv >/dev/null; then
        uv venv --quiet --no-project --allow-existing --python "$base" "$clew_venv" &&
            uv pip install --quiet --python "$python" --editable "$requirement"
    else
        "$base" -m venv "$clew_venv" &&
            "$python" -m pip install --quiet --disable-pip-version-check --editable "$requirement"
    fi
}

# Runs under the lock, in a subshell: the environment is made, or the script that wants it ends.
clew_make() {
    local extra=$1 base made_for=$1
    clew_is_ready "$extra" && return
    base=$(clew_find_python) || exit
    if [[ -e $clew_venv/clew.stamp ]] && clew_stamp >/dev/null; then
        # What there is stays; taking it away under a test that runs would break it.
        read -r made_for <"$clew_venv/clew.stamp"
        clew_holds "$made_for" "$extra" || made_for=$extra
        rm "$clew_venv/clew.stamp"
    else
        rm -rf "$clew_venv"
    fi
    clew_say "setting up .venv with $("$base" -V) (once; a minute or two)"
    clew_install "$made_for" "$base" >&2 || clew_refuse "setting up $clew_venv failed, see above; nothing of it will be used"
    printf '%s\n' "$made_for" "$(clew_stamp)" >"$clew_venv/clew.stamp.new"
    mv "$clew_venv/clew.stamp.new" "$clew_venv/clew.stamp"
}

# set_up run|tools|dev: returns with an environment that holds what a run needs, what figures and exports need
# beside, or what the tests need.
set_up() {
    clew_is_ready "$1" && return
    command -v flock >/dev/null || clew_refuse "flock (util-linux) is needed to set up"
    (flock 9 && clew_make "$1") 9<"$clew_root/pyproject.toml" || exit
}
