#!/bin/sh
# One calibration over Modbus: tumble-stand plays drive and block, tumble-node is the computer with its memory, and all
# that is commanded and read goes through tumble-gateway, by mbpoll. Ends with what the memory holds.
#
#   examples/try_gateway.sh [INTERFACE [FOLDER]]
#
# INTERFACE: a CAN interface of Linux that is up and that nobody else uses; vcan0 unless told otherwise. Without CAN in
# the kernel: ./tools/tumble uml -- examples/try_gateway.sh
# FOLDER: where scenario and memory stay, new or empty; unless told, a temporary one.
# Exit: 0 done, 2 bad usage or no such interface, 3 something failed and the last line says what, 77 no CAN here, or a
# program is missing.
set -u
interface=${1:-vcan0}
root=$(cd -- "$(dirname -- "$0")/.." && pwd)
registers=$root/docs/modbus.csv
ANSWERS=1                   # link state
IDLE=0 DONE=12 FAULT=13     # state, 2000h
START=1 ACCEPT=9            # command, 2002h
HELD=3 ACCEPTED=5           # verdict, 2120h:7

main() {
    case ${1:-} in
    -h | --help) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit 0 ;;
    -*) fail 2 "no such option: $1 (--help says what there is)" ;;
    esac
    [ $# -le 2 ] || fail 2 "more than INTERFACE and FOLDER"
    node=$(program tumble-node host/node "${TUMBLE_NODE:-}") || exit
    stand=$(program tumble-stand host/stand "${TUMBLE_STAND:-}") || exit
    gateway=$(program tumble-gateway host/gateway "${TUMBLE_GATEWAY:-}") || exit
    command -v mbpoll >/dev/null || fail 77 "mbpoll is not installed: apt install mbpoll"
    prepare "$@"
    start
    calibrate
    accept
    finish
}

# Path of a program: as told, built in this checkout, or installed.
program() {
    for path in "${3:-/}" "$root/build/host/$2/$1" "$(command -v "$1")"; do
        if [ -f "$path" ] && [ -x "$path" ]; then echo "$path"; return; fi
    done
    fail 77 "the program $1 is not built (tools/setup gateway builds it)"
}

fail() {
    echo "try_gateway: $2" >&2
    exit "$1"
}

# A folder, and in it the scenario: a stand that makes haste, and a block with a serial number.
prepare() {
    temporary='' processes=''
    trap clean EXIT
    trap 'exit 130' INT
    trap 'exit 143' TERM HUP
    if [ $# -gt 1 ]; then
        folder=$2
        mkdir -p -- "$folder" || exit 2
        [ -z "$(ls -A -- "$folder")" ] || fail 2 "$folder is not empty"
    else
        folder=$(mktemp -d) && temporary=$folder || exit 3
    fi
    cat >"$folder/stand.txt" <<END
motion.speed_deg_s = 720
motion.acceleration_deg_s2 = 7200
motion.settling_s = 0.05
profile.homing_fast_deg_s = 720
profile.homing_slow_deg_s = 90
procedure.settle_ms = 50
procedure.samples = 20
procedure.warm_up_samples = 5
procedure.gravity_limit_g = 1e-3
operator.mount_s = 0.5
keeper.serial = TB-0001
END
}

clean() {
    # shellcheck disable=SC2086 # numbers of processes
    [ -z "$processes" ] || kill $processes 2>/dev/null
    wait
    [ -z "$temporary" ] || rm -r -- "$temporary"
}

start() {
    "$stand" "$interface" "$folder/stand.txt" --seed 11 >/dev/null &
    processes=$!
    "$node" "$interface" "$folder/stand.txt" --nv "$folder/memory" >/dev/null &
    node_process=$! processes="$processes $!"
    "$gateway" --can "$interface" --tcp 127.0.0.1:0 --poll 200 --allow-commands 2>"$folder/gateway" &
    processes="$processes $!"
    wait_for "the gateway" grep -q ' at 127.0.0.1:' "$folder/gateway"
    port=$(sed -n 's/.* at 127\.0\.0\.1:\([0-9]*\).*/\1/p' "$folder/gateway")
    echo "tumble-stand, tumble-node and tumble-gateway run on $interface; Modbus at 127.0.0.1:$port"
    wait_for "node 1" is "Link state" $ANSWERS
    wait_for "node 1" is State $IDLE
}

calibrate() {
    give $START
    echo "START given; the table turns"
    wait_for "the end of the run" ended
    is State $DONE || fail 3 "the run ended with reason $(input Reason 3): docs/operations.md says what it means"
    wait_for "the verdict" is "Keeper: Verdict" $HELD
    echo "DONE; held, objections $(input "Keeper: Objections" 3) (64: there is no set to compare with). The proposal:"
    show "Proposal: K: K_xx" "Proposal: U0: U0_x"
}

accept() {
    accept_proposal
    wait_for "the verdict" is "Keeper: Verdict" $ACCEPTED
    wait_for "the active set" is "Active set: K: valid" 511
    echo "ACCEPT given; calibration counter $(input "Keeper: Calibration counter" 3:int). The active set:"
    show "Active set: K: K_xx" "Active set: U0: U0_x"
}

finish() {
    kill "$node_process"
    wait "$node_process"
    echo "The computer is off. What its memory holds:"
    "${TUMBLE:-$root/tools/tumble}" store dump "$folder/memory" || fail 3 "the memory cannot be read"
}

# In one request: keys of the session, command object, argument, angle (2), command, a number of ours that executes it.
give() {
    mbpoll -m tcp -p "$port" -a 1 -0 -q -t 4 -r 0 127.0.0.1 20304 17742 0 0 0 0 0 "$1" 1 >/dev/null ||
        fail 3 "the gateway refuses command $1"
}

# The same for ACCEPT, and behind it, with 0 for what lies between, the name of the proposal that was shown: its record CRC.
accept_proposal() {
    name=$(input "Proposal: Record CRC" 3 2 | sed 's/ (.*//')
    # shellcheck disable=SC2086 # two numbers
    mbpoll -m tcp -p "$port" -a 1 -0 -q -t 4 -r 0 127.0.0.1 20304 17742 0 0 0 0 0 "$ACCEPT" 1 \
        0 0 0 0 0 0 0 0 0 $name >/dev/null || fail 3 "the gateway refuses command $ACCEPT"
}

# input NAME TYPE [COUNT]: values of the newest snapshot, one a line; TYPE as mbpoll has it.
input() {
    at=$(awk -F, -v name="$1" '$1 == "input" && $NF == name { print $2; exit }' "$registers")
    mbpoll -m tcp -p "$port" -a 1 -0 -1 -q -B -t "$2" -r "$at" -c "${3:-1}" 127.0.0.1 2>/dev/null |
        sed -n 's/^\[[0-9]*\]:[[:space:]]*//p'
}

is() { [ "$(input "$1" 3)" = "$2" ]; }
ended() { is State $DONE || is State $FAULT; }

show() {
    input "$1" 3:float 9 | paste -d ' ' - - - | sed 's/^/    K, V\/g: /'
    input "$2" 3:float 3 | paste -d ' ' - - - | sed 's/^/    U0, V:  /'
}

# wait_for WHAT COMMAND...: until it succeeds, at most a minute, as long as all that was started runs.
wait_for() {
    what=$1
    shift
    tries=300
    until "$@"; do
        for process in $processes; do
            kill -0 "$process" 2>/dev/null || gone "$process"
        done
        tries=$((tries - 1))
        [ $tries -gt 0 ] || fail 3 "still waiting for $what after a minute"
        sleep 0.2
    done
}

# A program that has ended by itself has said why; the gateway in a file.
gone() {
    cat "$folder/gateway" >&2
    wait "$1"
    code=$?
    [ $code -gt 0 ] || code=3
    fail $code "a program has ended by itself while waiting for $what"
}

main "$@"
