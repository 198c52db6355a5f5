# An interrupt ends the comparison and leaves nothing, neither the result nor the heat maps that were done.
start_interruptible nsdf-cmp fixture/frames fixture/tiny.nsdf --samples 300000 --resolution 64 --measures none \
    --threads 1 -v --heatmap h_%d.ply -o r.txt
wait_for_message 'metaballs_0000.obj'
kill -INT "$pid"
code=0
wait_for "$pid" 60 || code=$?
echo "exit $code"
tail -n 1 interrupted.err
no_leftovers . fixture interrupted.err interrupted.out
