# Every kind of model, loss, sampling and normalisation gives a file that verifies.
try() {
    nsdf-enc -q "${tiny[@]}" --no-verify "$@" -o model.nsdf fixture/frames || give_up "nsdf-enc $* failed"
    nsdf-dec -q --verify model.nsdf >verified || give_up "$*: the file does not verify"
    nsdf-dec -q --resolution 12 --frames 0 -o null: model.nsdf || give_up "$*: the file does not decode"
    echo "ok: $*"
}
try --input xyz
try --input xyzt
try --input fourier
try --input fourier --fourier-trained
try --weights constant --input xyz
try --weights low-rank --input xyz
try --activation relu
try --activation tanh
try --loss mae
try --loss surface
try --sampling rejection
try --time-norm speed --input xyzt
try --sdf-norm unit
try --quantiser minmax
try --hard-samples off
try --optimiser adam
try --weight-bits 32
