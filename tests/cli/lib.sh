# Helpers for the cases; loaded by run_cli.sh.  They print a line on success and end the case with a reason on failure.
# shellcheck shell=bash disable=SC2034

# The smallest model that is worth the name, for cases that need any file.
tiny=(--layers 2 --width 16 --steps 60 --batch-points 256 --samples 4000 --resolution 24 --threads 2)

give_up() {
    printf 'FAILED: %s\n' "$*" >&2
    exit 1
}

skip() {
    printf '%s\n' "$*" >&2
    exit 77
}

# fails CODE TEXT COMMAND...: the command must exit with CODE, print nothing on stdout, and one line on stderr that
# begins with its name and contains TEXT.
fails() {
    local code=$1 text=$2 found=0
    shift 2
    "$@" >fails.out 2>fails.err || found=$?
    [ "$found" = "$code" ] || give_up "'$*' ended with $found, expected $code: $(head -c 300 fails.err)"
    [ ! -s fails.out ] || give_up "'$*' failed but printed on stdout: $(head -c 300 fails.out)"
    [ "$(wc -l <fails.err)" = 1 ] || give_up "'$*' should print one line: $(head -c 600 fails.err)"
    [[ $(<fails.err) == "${1##*/}: "*"$text"* ]] || give_up "'$*' should mention '$text': $(<fails.err)"
    rm -f fails.out fails.err
    echo "exit $code: $text"
}

# no_leftovers FOLDER [NAME...]: nothing but these names is in the folder.
no_leftovers() {
    local folder=$1 found
    shift
    found=$(find "$folder" -mindepth 1 -maxdepth 1 -printf '%f\n' | LC_ALL=C sort | tr '\n' ' ')
    [ "$found" = "$(printf '%s\n' "$@" | LC_ALL=C sort | sed '/^$/d' | tr '\n' ' ')" ] ||
        give_up "left in $folder: $found"
    echo "nothing left behind"
}

same() {
    cmp -s "$1" "$2" || give_up "$1 and $2 differ"
    echo "equal"
}

size_of() {
    stat -c %s "$1"
}

# Overwrites the byte at an offset: poke FILE OFFSET HEX
poke() {
    printf '%b' "\\x$3" | dd of="$1" bs=1 seek="$2" conv=notrunc status=none
}

# Flips the lowest bit of the byte at an offset.
flip() {
    local byte
    byte=$(od -An -tu1 -j "$2" -N 1 "$1" | tr -d ' ')
    poke "$1" "$2" "$(printf '%02x' $((byte ^ 1)))"
}

# Starts a command in the background with SIGINT at its default (bash sets it to ignored for background jobs); its
# number is in $pid, its messages are in interrupted.err.
start_interruptible() {
    set -m
    "$@" >interrupted.out 2>interrupted.err &
    pid=$!
    set +m
}

# wait_for_message TEXT: until what start_interruptible runs has said so, a minute at most.
wait_for_message() {
    local i
    for ((i = 0; i < 3000; i++)); do
        if grep -qs "$1" interrupted.err; then break; fi
        sleep 0.02
    done
}

# serve FILE MODE [LIMIT]: starts a server of the file (tests/http) and sets $url.  The case is skipped where the
# programs read no URLs.
serve() {
    local program port
    program=$(dirname "$(command -v nsdf-dec)")/../tests/http_server
    if [ ! -x "$program" ] || nsdf-dec --info http://127.0.0.1:1/ 2>&1 | grep -q 'without libcurl'; then
        skip "the programs read no URLs"
    fi
    export no_proxy=127.0.0.1
    coproc SERVER { exec "$program" "$@"; }
    read -r port <&"${SERVER[0]}"
    url=http://127.0.0.1:$port/file.nsdf
}

# Stops it; what it was asked for is in $requests, what it sent in $sent.
serve_no_more() {
    local pid=$SERVER_PID
    eval "exec ${SERVER[1]}>&-"
    read -r requests sent <&"${SERVER[0]}"
    wait "$pid"
}

# serve_tls FOLDER: makes a certificate of its own, ca.pem, for "localhost" and serves the files of FOLDER with it; sets
# $port.  The case is skipped where there is no nginx or openssl.
serve_tls() {
    local folder tries=50
    folder=$(cd "$1" && pwd)
    command -v openssl >/dev/null || skip "openssl is not installed"
    PATH=$PATH:/usr/sbin command -v nginx >/dev/null || skip "nginx is not installed"
    ! nsdf-dec --info http://127.0.0.1:1/ 2>&1 | grep -q 'without libcurl' || skip "the programs read no URLs"
    export no_proxy=localhost,127.0.0.1
    unset CURL_CA_BUNDLE SSL_CERT_FILE SSL_CERT_DIR
    trap 'kill "$tls_server" 2>/dev/null' EXIT
    openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=localhost -addext subjectAltName=DNS:localhost \
        -keyout key.pem -out ca.pem 2>/dev/null
    for port in 14431 24431 34431 44431 54431; do
        cat >nginx.conf <<END
daemon off; pid $PWD/nginx.pid; error_log $PWD/nginx.log; worker_processes 1;
$([ "$(id -u)" != 0 ] || echo "user root;")
events {}
http {
    access_log $PWD/access.log; client_body_temp_path $PWD; proxy_temp_path $PWD; fastcgi_temp_path $PWD;
    uwsgi_temp_path $PWD; scgi_temp_path $PWD;
    server {
        listen 127.0.0.1:$port ssl; ssl_certificate $PWD/ca.pem; ssl_certificate_key $PWD/key.pem; root $folder;
    }
}
END
        PATH=$PATH:/usr/sbin nginx -p "$PWD" -c "$PWD/nginx.conf" 2>>nginx.log &
        tls_server=$!
        while kill -0 "$tls_server" 2>/dev/null && [ ! -s nginx.pid ] && [ "$tries" -gt 0 ]; do
            sleep 0.1
            tries=$((tries - 1))
        done
        sleep 0.2
        ! kill -0 "$tls_server" 2>/dev/null || return 0
    done
    give_up "nginx does not start: $(tail -n 1 nginx.log)"
}

serve_tls_no_more() {
    kill "$tls_server"
    wait "$tls_server" || true
}

# wait_for PID SECONDS: the exit code of the process, or failure when it does not end in time.
wait_for() {
    local process=$1 tries=$(($2 * 10)) code=0
    while kill -0 "$process" 2>/dev/null && [ "$tries" -gt 0 ]; do
        sleep 0.1
        tries=$((tries - 1))
    done
    if kill -KILL "$process" 2>/dev/null; then
        give_up "process $process did not end in $2 seconds"
    fi
    wait "$process" || code=$?
    return "$code"
}
