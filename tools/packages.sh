# Part of tools/setup: what is lacking of tools/packages.txt, and how it may be installed.
# shellcheck shell=bash

# What is lacking of tools/packages.txt: all of it at once, or what can be had of it.
install_packages() {
    local for_profile shown names needed=() rows=()
    while read -r for_profile shown names; do
        if ! includes "$for_profile" || is_there "$shown"; then continue; fi
        if [[ $for_profile == core ]]; then needed+=($names); else rows+=("$names"); fi
    done <<<"$(grep -v "^#" tools/packages.txt)"
    local all=("${needed[@]}" ${rows[*]})
    announce "${all[*]}"
    if ((${#all[@]})); then
        remedy="sudo apt-get install --no-install-recommends ${all[*]}"
        may_install && install "${all[@]}" && remedy="" || install_one_by_one
    fi
    has_python || fail "no Python of version 3.10 or later with venv and headers, even after installing python3"
}

install_one_by_one() {
    ((${#needed[@]} == 0)) || { may_install && install "${needed[@]}"; } ||
        fail "cannot install ${needed[*]}: $why. Or ask an administrator for: $remedy"
    local lacking=()
    for names in "${rows[@]}"; do
        may_install && install $names || { without "${names%% *}" && lacking+=($names); }
    done
    remedy=${lacking[*]:+sudo apt-get install --no-install-recommends ${lacking[*]}}
}

is_there() {
    if [[ $1 == has_* ]]; then "$1"; else have "$1"; fi
}

has_compiler() { echo '#include <stdio.h>' | cc -E - >/dev/null; }
has_modbus() { pkg-config --exists "libmodbus >= 3.1.6"; }
has_fuzzer() { echo 'int LLVMFuzzerTestOneInput(void) { return 0; }' | clang-19 -fsanitize=fuzzer -xc - -o /dev/null; }

# The libraries that WeasyPrint lays out text with, and a font.
has_pango() {
    local known
    known=$(ldconfig -p)
    [[ $known == *libpangoft2-1.0.so.0* && $known == *libharfbuzz-subset.so.0* ]]
}

# Set `python` to an interpreter that can make an environment and has the headers that an extension needs.
has_python() {
    local candidate
    for candidate in python3 /usr/bin/python3; do
        python=$("$candidate" - <<'PYTHON'
import ensurepip, os, sys, sysconfig, venv
assert sys.version_info >= (3, 10) and os.path.exists(os.path.join(sysconfig.get_paths()["include"], "Python.h"))
print(sys.executable)
PYTHON
        ) && return
    done
    return 1
}

# May packages be installed? Asks for a password where somebody can give it, once. Sets as_root; if not, `why`.
may_install() {
    [[ $allowed ]] || {
        as_root=()
        allowed=no
        if ! have apt-get; then
            why="there is no apt-get; these are the names in Debian"
        elif ((EUID == 0)); then
            allowed=yes
        elif ! have sudo; then
            why="you are not root, and there is no sudo"
        elif [[ ! -t 8 ]]; then
            why="sudo does not do it without a password, and there is no terminal to ask for it"
            as_root=(sudo -n)
            sudo -n true && allowed=yes
        else
            quiet
            why="sudo refused"
            as_root=(sudo -n)
            sudo -p "tumble: sudo wants the password of %p, to install these packages: " true && allowed=yes
        fi
    }
    [[ $allowed == yes ]]
}

# Install packages of the distribution; on failure `why` says what stood in the way.
install() {
    say "installing $*"
    # Lists of other vendors may fail to load; what matters is whether the packages can be had.
    [[ $lists_are_fresh ]] || run "${as_root[@]}" apt-get update
    lists_are_fresh=yes
    local get=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive NEEDRESTART_SUSPEND=1
        apt-get install -y --no-install-recommends -o DPkg::Lock::Timeout=600 "$@")
    # Once more after mending what a killed installation left behind.
    run "${get[@]}" || { run "${as_root[@]}" dpkg --configure -a && run "${get[@]}"; } && return
    unreached=yes
    why="apt-get failed; is the network reachable?"
    return 1
}
