nsdf-cmp --help | head -n 1
nsdf-cmp --version | grep -c '^nsdf-cmp [0-9]'
